#include "lsmvs/refinement/step/vertex_frames.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace lsmvs {

std::vector<Eigen::Vector3d> VertexDirections(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> directions(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, f);
    for (const int v : mesh.faces[f]) directions[static_cast<size_t>(v)] += normal;
  }
  for (Eigen::Vector3d& direction : directions) {
    const double length = direction.norm();
    direction = length > 0 ? Eigen::Vector3d(direction / length) : Eigen::Vector3d(0, 0, 1);
  }
  return directions;
}

std::vector<double> MeanPixelSizes(const TriangleMesh& mesh, const FacePairs& pairs) {
  std::vector<double> sums(mesh.vertices.size(), 0.0);
  std::vector<int> counts(mesh.vertices.size(), 0);
  std::vector<float> seen;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!pairs.Seen(f)) continue;
    seen.push_back(pairs.pixel_size[f]);
    for (const int v : mesh.faces[f]) {
      sums[static_cast<size_t>(v)] += pairs.pixel_size[f];
      ++counts[static_cast<size_t>(v)];
    }
  }
  if (seen.empty()) return sums;
  const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
  std::nth_element(seen.begin(), middle, seen.end());
  for (size_t v = 0; v < sums.size(); ++v) {
    sums[v] = counts[v] > 0 ? sums[v] / counts[v] : static_cast<double>(*middle);
  }
  return sums;
}

}  // namespace lsmvs
