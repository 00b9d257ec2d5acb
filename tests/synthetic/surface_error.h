#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {

// Distances between a result and the truth, world units. Divide by the scene's gsd.
struct SurfaceError {
  double mean = 0;  // of the absolute distance
  double p95 = 0;   // 95 % are nearer
  double max = 0;
  double bias = 0;  // mean of the signed distance: positive outside of the solid
  size_t num_samples = 0;

  // Share of the samples nearer than `distance`.
  double Within(double distance) const;
  std::vector<double> sorted;  // absolute distances, ascending
};

// Accuracy: distances of random points of the mesh (uniform by area) to the shape. With
// `min_num_views` > 0 only points that the mesh itself shows to that many views of the scene count.
SurfaceError MeasureAccuracy(const TriangleMesh& mesh, const SyntheticScene& scene,
                             int min_num_views = 0, size_t num_samples = 20000, uint64_t seed = 0);

// Completeness: distances of random points of the true surface that `min_num_views` views see to
// the mesh.
SurfaceError MeasureCompleteness(const TriangleMesh& mesh, const SyntheticScene& scene,
                                 int min_num_views = 2, size_t num_samples = 20000,
                                 uint64_t seed = 0);

// Distances of a cloud's points.
SurfaceError MeasureCloud(const VisibilityCloud& cloud, const SyntheticScene& scene);

}  // namespace lsmvs
