#include "lsmvs/synthetic/surface_error.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lsmvs/synthetic/area_sampler.h"
#include "lsmvs/synthetic/mesh_shape.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/truth.h"

namespace lsmvs {

namespace {

constexpr size_t kBlock = 256;

SurfaceError Summarise(const std::vector<double>& signed_distances) {
  SurfaceError error;
  error.num_samples = signed_distances.size();
  if (signed_distances.empty()) return error;
  for (const double distance : signed_distances) {
    error.bias += distance;
    error.mean += std::abs(distance);
    error.sorted.push_back(std::abs(distance));
  }
  const double count = static_cast<double>(signed_distances.size());
  error.bias /= count;
  error.mean /= count;
  std::sort(error.sorted.begin(), error.sorted.end());
  error.p95 = error.sorted[static_cast<size_t>(0.95 * (count - 1))];
  error.max = error.sorted.back();
  return error;
}

int CountViews(const Shape& shape, const Scene& scene, const Eigen::Vector3d& x,
               const Eigen::Vector3d& normal) {
  return static_cast<int>(
      std::count_if(scene.views.begin(), scene.views.end(),
                    [&](const View& view) { return SeesSurfacePoint(shape, view, x, normal); }));
}

SurfaceError MeasurePoints(const std::vector<Eigen::Vector3d>& points, const Shape& shape) {
  std::vector<double> distances(points.size());
  ParallelFor(RunContext(), points.size(), kBlock,
              [&](size_t i) { distances[i] = shape.SignedDistance(points[i]); });
  return Summarise(distances);
}

// Points of the mesh that its own surface shows to enough views.
std::vector<Eigen::Vector3d> VisiblePoints(const TriangleMesh& mesh, const Scene& scene,
                                           int min_num_views, size_t num_samples, uint64_t seed) {
  const AreaSampler sampler(mesh);
  std::optional<MeshShape> own_surface;
  if (min_num_views > 0) own_surface.emplace(mesh);
  std::vector<std::optional<Eigen::Vector3d>> samples(num_samples);
  ParallelFor(RunContext(), num_samples, kBlock, [&](size_t i) {
    Random random(seed, i);
    const AreaSample sample = sampler.Draw(&random);
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, sample.face).normalized();
    if (min_num_views <= 0 ||
        CountViews(*own_surface, scene, sample.position, normal) >= min_num_views) {
      samples[i] = sample.position;
    }
  });
  std::vector<Eigen::Vector3d> points;
  for (const auto& sample : samples) {
    if (sample) points.push_back(*sample);
  }
  return points;
}

}  // namespace

double SurfaceError::Within(double distance) const {
  if (sorted.empty()) return 0.0;
  const auto first_beyond = std::upper_bound(sorted.begin(), sorted.end(), distance);
  return static_cast<double>(first_beyond - sorted.begin()) / static_cast<double>(sorted.size());
}

SurfaceError MeasureAccuracy(const TriangleMesh& mesh, const SyntheticScene& scene,
                             int min_num_views, size_t num_samples, uint64_t seed) {
  return MeasurePoints(VisiblePoints(mesh, scene.scene, min_num_views, num_samples, seed),
                       *scene.shape);
}

SurfaceError MeasureCompleteness(const TriangleMesh& mesh, const SyntheticScene& scene,
                                 int min_num_views, size_t num_samples, uint64_t seed) {
  SampledCloudOptions options;
  options.num_points = num_samples;
  options.min_num_views = min_num_views;
  options.seed = seed;
  const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, options, RunContext());
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& x : cloud.positions) points.push_back(x.cast<double>());
  return MeasurePoints(points, MeshShape(mesh));
}

SurfaceError MeasureCloud(const VisibilityCloud& cloud, const SyntheticScene& scene) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& x : cloud.positions) points.push_back(x.cast<double>());
  return MeasurePoints(points, *scene.shape);
}

}  // namespace lsmvs
