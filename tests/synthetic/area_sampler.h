#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs {

struct AreaSample {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  size_t face = 0;
};

// Draws points uniformly by area from a mesh, which must outlive it and have area. O(log F) a
// point.
class AreaSampler {
 public:
  explicit AreaSampler(const TriangleMesh& mesh);
  AreaSample Draw(Random* random) const;

 private:
  const TriangleMesh& mesh_;
  std::vector<double> cumulative_area_;
};

}  // namespace lsmvs
