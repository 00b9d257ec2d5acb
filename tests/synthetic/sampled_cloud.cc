#include "lsmvs/synthetic/sampled_cloud.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/synthetic/area_sampler.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/truth.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr size_t kBatch = 8192;
constexpr size_t kBlock = 256;
constexpr size_t kMaxCandidatesPerPoint = 300;
// Curved shapes are drawn from a mesh this fine (bounds' diagonal / edge) and moved onto the
// surface.
constexpr double kMeshFineness = 150.0;

struct SeenPoint {
  SurfacePoint point;
  std::vector<uint32_t> views;
};

class Sampler {
 public:
  Sampler(const Shape& shape, const Scene& scene, const SampledCloudOptions& options)
      : shape_(shape),
        scene_(scene),
        options_(options),
        bounds_(shape.Bounds()),
        mesh_(shape.Mesh(bounds_.diagonal().norm() / kMeshFineness)),
        sampler_(mesh_) {}

  // The first num_points candidates that are seen well enough.
  std::vector<SeenPoint> Draw(const RunContext& context) const {
    std::vector<SeenPoint> points;
    std::vector<SeenPoint> batch(kBatch);
    const size_t max_candidates = kMaxCandidatesPerPoint * options_.num_points + kBatch;
    for (size_t first = 0; points.size() < options_.num_points; first += kBatch) {
      LSMVS_CHECK_LT(first, max_candidates);
      ParallelFor(context, kBatch, kBlock, [&](size_t i) { batch[i] = Candidate(first + i); });
      for (SeenPoint& candidate : batch) {
        if (candidate.views.empty() || points.size() == options_.num_points) continue;
        points.push_back(std::move(candidate));
      }
    }
    return points;
  }

  SeenPoint Outlier(size_t index) const {
    Random random(options_.seed, 3 * index + 1);
    const Eigen::Vector3d grown_by = 0.25 * bounds_.sizes();
    SeenPoint outlier;
    constexpr int kMaxTries = 1000;
    for (int i = 0; i < kMaxTries && outlier.views.size() < 2; ++i) {
      for (int k = 0; k < 3; ++k) {
        outlier.point.position[k] =
            random.Uniform(bounds_.min()[k] - grown_by[k], bounds_.max()[k] + grown_by[k]);
      }
      outlier.views = RandomViewsOf(outlier.point.position, 2 + random.Below(3), &random);
    }
    outlier.point.normal = random.Gaussian3().normalized();
    if (outlier.views.empty()) return outlier;
    const Eigen::Vector3d center = scene_.views[outlier.views.front()].CenterInWorld();
    if (outlier.point.normal.dot(center - outlier.point.position) < 0) outlier.point.normal *= -1;
    return outlier;
  }

 private:
  // Without views if the density, or what is seen, rejects it.
  SeenPoint Candidate(size_t index) const {
    Random random(options_.seed, 3 * index);
    SeenPoint candidate;
    candidate.point = shape_.Closest(sampler_.Draw(&random).position);
    if (random.Uniform() > RelativeDensity(candidate.point.position)) return candidate;
    for (size_t v = 0; v < scene_.views.size(); ++v) {
      if (SeesSurfacePoint(shape_, scene_.views[v], candidate.point.position,
                           candidate.point.normal, options_.max_angle_deg)) {
        candidate.views.push_back(static_cast<uint32_t>(v));
      }
    }
    if (static_cast<int>(candidate.views.size()) < options_.min_num_views) {
      candidate.views.clear();
    } else {
      MissViews(&random, &candidate.views);
    }
    return candidate;
  }

  double RelativeDensity(const Eigen::Vector3d& x) const {
    const double place =
        std::clamp((x.x() - bounds_.min().x()) / std::max(bounds_.sizes().x(), 1e-300), 0.0, 1.0);
    return std::pow(options_.density_ratio, place - 1.0);
  }

  void MissViews(Random* random, std::vector<uint32_t>* views) const {
    for (size_t i = views->size(); i-- > 0;) {
      const bool miss = random->Uniform() < options_.miss_probability;
      if (miss && static_cast<int>(views->size()) > options_.min_num_views) {
        views->erase(views->begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }

  std::vector<uint32_t> RandomViewsOf(const Eigen::Vector3d& x, size_t count,
                                      Random* random) const {
    std::vector<uint32_t> views;
    for (size_t v = 0; v < scene_.views.size(); ++v) {
      const View& view = scene_.views[v];
      if (view.Depth(x) > 0 && view.camera.Contains(view.camera.Project(view.cam_from_world * x))) {
        views.push_back(static_cast<uint32_t>(v));
      }
    }
    while (views.size() > count) {
      views.erase(views.begin() + static_cast<std::ptrdiff_t>(random->Below(views.size())));
    }
    return views;
  }

  const Shape& shape_;
  const Scene& scene_;
  const SampledCloudOptions& options_;
  Eigen::AlignedBox3d bounds_;
  TriangleMesh mesh_;
  AreaSampler sampler_;
};

}  // namespace

VisibilityCloud SampleCloud(const Shape& shape, const Scene& scene,
                            const SampledCloudOptions& options, const RunContext& context) {
  LSMVS_CHECK(options.outlier_fraction >= 0 && options.outlier_fraction < 1);
  LSMVS_CHECK_GE(options.density_ratio, 1.0);
  LSMVS_CHECK_GE(options.min_num_views, 1);
  const Sampler sampler(shape, scene, options);
  const Color gray(128, 128, 128);
  VisibilityCloud cloud;
  const std::vector<SeenPoint> points = sampler.Draw(context);
  for (size_t p = 0; p < points.size(); ++p) {
    Random random(options.seed, 3 * p + 2);
    const Eigen::Vector3d x = points[p].point.position + options.noise * random.Gaussian3();
    cloud.Add(x.cast<float>(), points[p].point.normal.cast<float>(), gray, points[p].views);
  }
  const double share = options.outlier_fraction;
  const auto num_outliers = static_cast<size_t>(
      std::llround(share / (1 - share) * static_cast<double>(options.num_points)));
  for (size_t i = 0; i < num_outliers; ++i) {
    const SeenPoint outlier = sampler.Outlier(i);
    cloud.Add(outlier.point.position.cast<float>(), outlier.point.normal.cast<float>(), gray,
              outlier.views);
  }
  return cloud;
}

std::vector<SparsePoint> SampleSparsePoints(const Shape& shape, const Scene& scene,
                                            size_t num_points, double noise, uint64_t seed,
                                            const RunContext& context) {
  SampledCloudOptions options;
  options.num_points = num_points;
  options.noise = noise;
  options.seed = seed;
  std::vector<SparsePoint> points;
  const Sampler sampler(shape, scene, options);
  for (const SeenPoint& seen : sampler.Draw(context)) {
    Random random(seed, 3 * points.size() + 2);
    SparsePoint point;
    point.x_in_world = seen.point.position + noise * random.Gaussian3();
    point.color = Color(128, 128, 128);
    point.view_idxs.assign(seen.views.begin(), seen.views.end());
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace lsmvs
