#include "lsmvs/synthetic/area_sampler.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/util/check.h"

namespace lsmvs {

AreaSampler::AreaSampler(const TriangleMesh& mesh) : mesh_(mesh) {
  double sum = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    sum += 0.5 * FaceNormalTimesTwiceArea(mesh, f).norm();
    cumulative_area_.push_back(sum);
  }
  LSMVS_CHECK_GT(sum, 0.0);
}

AreaSample AreaSampler::Draw(Random* random) const {
  const double area = random->Uniform() * cumulative_area_.back();
  const auto found = std::upper_bound(cumulative_area_.begin(), cumulative_area_.end(), area);
  const size_t face =
      std::min(static_cast<size_t>(found - cumulative_area_.begin()), cumulative_area_.size() - 1);
  const double root = std::sqrt(random->Uniform()), share = random->Uniform();
  const Eigen::Vector3i& f = mesh_.faces[face];
  return {(1 - root) * mesh_.vertices[f[0]] + root * (1 - share) * mesh_.vertices[f[1]] +
              root * share * mesh_.vertices[f[2]],
          face};
}

}  // namespace lsmvs
