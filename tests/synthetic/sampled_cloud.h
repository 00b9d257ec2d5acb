#pragma once

#include <cstdint>
#include <optional>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/synthetic/shape.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SampledCloudOptions {
  size_t num_points = 10000;  // on the surface, seen by `min_num_views` or more
  double noise =
      0.0;  // standard deviation of an isotropic Gaussian, world units (multiples of the gsd)
  double outlier_fraction =
      0.0;  // outliers / all points; uniform in the bounds grown by half, with 2 to 4 random views
  double density_ratio =
      1.0;  // densest / sparsest: the density varies exponentially along the world's x axis
  double miss_probability =
      0.0;  // that a view that sees a point is not listed (at least min_num_views stay)
  int min_num_views = 2;
  double max_angle_deg = 75.0;  // between normal and line of sight
  uint64_t seed = 0;
};

// Random points on the shape with the views that see them: what an ideal or a bad stereo would
// give. Normals are the true ones (of outliers random ones that face a view), colours grey. Points
// come in random order, outliers after the others. Deterministic for any number of threads. Throws
// std::logic_error if hardly any part of the shape is seen.
VisibilityCloud SampleCloud(const Shape& shape, const Scene& scene,
                            const SampledCloudOptions& options, const RunContext& context);

// Points with tracks for Scene::points: seen by >= 2 views, moved by Gaussian `noise`.
std::vector<SparsePoint> SampleSparsePoints(const Shape& shape, const Scene& scene,
                                            size_t num_points, double noise, uint64_t seed,
                                            const RunContext& context);

}  // namespace lsmvs
