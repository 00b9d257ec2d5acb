#include "lsmvs/stereo/patch_match.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>

#include "lsmvs/geometry/inverse_depth_transfer.h"
#include "lsmvs/geometry/triangulation.h"
#include "lsmvs/image/largest_image.h"
#include "lsmvs/scene/packed_depth_map.h"
#include "lsmvs/stereo/patch_match/level_matcher.h"
#include "lsmvs/stereo/patch_match/textureless_filter.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

// The coarsest level keeps at least so many pixels along the shorter side.
constexpr int kMinCoarseSide = 60;
// For the cost estimate, measured on 1536 x 1024 photos: windows matched a full-resolution pixel in
// both passes, the time of one bilinear sample, and of all else a pixel.
constexpr double kWindowsPerPixel = 130;
constexpr double kSecondsPerSample = 1.2e-9;
constexpr double kSecondsPerPixel = 1.5e-6;
// Sparse points are few on ground before the camera, on what stands in the foreground and behind
// the scene: depths so many times beyond their range are tried as well. Towards the far end that
// costs nothing. The near end is wide in inverse depth: with 2.2 and 3.2 random trials find shards
// in the air above trees that the wind moves.
constexpr double kWidenNear = 1.6, kWidenFar = 3.2;
// Ground before somebody who stands on it moves by up to so many pixels per pixel in photos that
// are some steps apart. Few sparse points lie on it, so that its slope must be found: on a rendered
// courtyard, six trials in each of the first sweeps of the coarsest level raise the share of the
// ground with the right depth from .19 to .64.
constexpr float kSteepSlope = 2.0f;
constexpr int kSteepTrials = 6;
// A pixel has texture of its own if the grey variance of the 5 x 5 pixels around it is so many
// times that of the noise: of windows of noise alone, one in 400 gets there.
constexpr int kTextureRadius = 2;
constexpr float kMinTextureToNoise = 2;
// Windows whose grey variance is not so many times that of the noise are taken twice as wide.
constexpr float kMinWindowToNoise = 4;
// Displacement in the neighbours by which a plain zone may bulge out of its rim's chord, and by
// which the depths of adjacent pixels of one surface differ; pixels.
constexpr double kMaxTexturelessBulgePx = 4, kMaxTexturelessStepPx = 1.5;
// Grey variance that rounding to whole levels leaves at any level of the pyramid.
constexpr double kRoundingVariance = 0.1;

void CopyTo(const Eigen::Matrix3d& matrix, float* out) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(matrix(i / 3, i % 3));
}
void CopyTo(const Eigen::Vector3d& vector, float* out) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(vector[i]);
}

// Everything that one level's MatchingProblem points to.
struct Level {
  PinholeCamera camera;
  std::shared_ptr<const GrayImage> gray;
  std::vector<std::unique_ptr<PackedImage>> cells;
  std::vector<std::unique_ptr<PlaneMap>> neighbor_planes;
  MatchingProblem problem;
};

// Many sweeps where pixels are few, hardly more than the final refinement where they are many.
std::vector<SweepSettings> Schedule(int level, bool first, bool geometric,
                                    const PatchMatchOptions& options) {
  const SweepSettings refine{.num_propagated = 4, .parabola_px = 0.5f, .parabola_slope = 0.1f};
  if (level == 0) return {{.num_propagated = 4, .parabola_px = 0.5f}};
  if (geometric) return {refine};
  std::vector<SweepSettings> sweeps;
  const int num_sweeps = first ? options.num_iterations : level == 1 ? 1 : 2;
  for (int i = 0; i < num_sweeps; ++i) {
    const float scale = std::pow(0.6f, static_cast<float>(i));
    sweeps.push_back({.num_propagated = level == 1 ? 4 : 8,
                      .num_perturbed = level == 1 ? 1 : 2,
                      .num_steep = first && i < 4 ? kSteepTrials : 0,
                      .depth_px = (first ? 3.0f : 1.0f) * scale,
                      .slope = (first ? 0.5f : 0.2f) * scale,
                      .steep_slope = kSteepSlope * scale,
                      .num_random = first && i < 3 ? 2 : 0});
  }
  sweeps.push_back(refine);
  return sweeps;
}

class ViewMatcher {
 public:
  ViewMatcher(const Scene& scene, const ImageStore& images, int view_idx,
              const std::vector<Neighbor>& neighbors, const DepthRange& range,
              const DepthMapSource* maps, const PatchMatchOptions& options)
      : scene_(scene), images_(images), view_idx_(view_idx), maps_(maps), options_(options) {
    const size_t limit = static_cast<size_t>(options.max_num_neighbors);
    for (const Neighbor& neighbor : neighbors) {
      if (neighbor_idxs_.size() < limit) neighbor_idxs_.push_back(neighbor.view_idx);
    }
    const double near = options.depth_min.value_or(range.min / kWidenNear);
    const double far = options.depth_max.value_or(range.max * kWidenFar);
    if (near > 0 && far > near) {
      min_q_ = static_cast<float>(1 / far);
      max_q_ = static_cast<float>(1 / near);
    }
  }

  bool CanMatch() const { return !neighbor_idxs_.empty() && max_q_ > min_q_; }
  DepthMap Run(const RunContext& context);
  DepthMap EmptyMap(int level) const {
    const PinholeCamera camera = images_.Camera(view_idx_, level);
    return {Raster<float>(camera.width, camera.height, 0.0f),
            Raster<Eigen::Vector3f>(camera.width, camera.height, Eigen::Vector3f::Zero())};
  }

 private:
  Level MakeLevel(int level) const;
  void AddSource(const PinholeCamera& camera, int neighbor_idx, int level, Level* out) const;
  void AddSourcePlanes(const PinholeCamera& camera, int neighbor_idx, Level* out) const;
  std::vector<uint32_t> SeedPoints() const;
  PlaneMap SeedPlanes(const PinholeCamera& camera) const;
  PlaneMap OwnPlanes() const;
  int CoarsestLevel() const;
  LevelMatcher MakeMatcher(const Level& level, int level_idx) const {
    return {level.problem, min_q_, max_q_,
            static_cast<uint64_t>(view_idx_) * 1000 + static_cast<uint64_t>(level_idx) + 77};
  }
  void ApplyMask(int level, PlaneMap* planes) const;
  void FilterByAngle(const PinholeCamera& camera, PlaneMap* planes) const;
  void FilterExtrapolation(const Level& level, PlaneMap* planes) const;
  double MeanBaseline() const;

  const Scene& scene_;
  const ImageStore& images_;
  int view_idx_;
  const DepthMapSource* maps_;
  const PatchMatchOptions& options_;
  std::vector<int> neighbor_idxs_;
  float min_q_ = 0, max_q_ = 0;
};

int ViewMatcher::CoarsestLevel() const {
  int level = 0;
  for (;; ++level) {
    const PinholeCamera next = images_.Camera(view_idx_, level + 1);
    if (std::min(next.width, next.height) < kMinCoarseSide) return level;
  }
}

void ViewMatcher::AddSource(const PinholeCamera& camera, int neighbor_idx, int level,
                            Level* out) const {
  const View& reference = scene_.views[static_cast<size_t>(view_idx_)];
  const View& neighbor = scene_.views[static_cast<size_t>(neighbor_idx)];
  PinholeCamera neighbor_camera = images_.Camera(neighbor_idx, level);
  neighbor_camera.cx -= 0.5;  // SourceView counts from the first pixel's centre
  neighbor_camera.cy -= 0.5;
  const InverseDepthTransfer geometry = MakeInverseDepthTransfer(
      neighbor_camera, camera, neighbor.cam_from_world * reference.cam_from_world.Inverse());
  out->cells.push_back(std::make_unique<PackedImage>(*images_.Gray(neighbor_idx, level)));
  SourceView source;
  source.image = out->cells.back().get();
  CopyTo(geometry.homography, source.m);
  CopyTo(geometry.epipole, source.e);
  out->problem.sources.push_back(source);
}

void ViewMatcher::AddSourcePlanes(const PinholeCamera& camera, int neighbor_idx, Level* out) const {
  SourcePlanes planes;
  if (const auto map = maps_->Get(neighbor_idx)) {
    const View& reference = scene_.views[static_cast<size_t>(view_idx_)];
    const View& neighbor = scene_.views[static_cast<size_t>(neighbor_idx)];
    const PinholeCamera map_camera = neighbor.camera.Resized(map->depth.width, map->depth.height);
    const Rigid3 neighbor_from_reference =
        neighbor.cam_from_world * reference.cam_from_world.Inverse();
    const InverseDepthTransfer forward =
        MakeInverseDepthTransfer(map_camera, camera, neighbor_from_reference);
    const InverseDepthTransfer backward =
        MakeInverseDepthTransfer(camera, map_camera, neighbor_from_reference.Inverse());
    out->neighbor_planes.push_back(std::make_unique<PlaneMap>(ToPlaneMap(map_camera, *map)));
    planes.planes = out->neighbor_planes.back().get();
    CopyTo(forward.homography, planes.forward_m);
    CopyTo(forward.epipole, planes.forward_e);
    CopyTo(backward.homography, planes.backward_m);
    CopyTo(backward.epipole, planes.backward_e);
  }
  out->problem.source_planes.push_back(planes);
}

Level ViewMatcher::MakeLevel(int level) const {
  Level out;
  out.camera = images_.Camera(view_idx_, level);
  out.gray = images_.Gray(view_idx_, level);
  MatchingProblem& problem = out.problem;
  problem.gray = out.gray.get();
  problem.camera = out.camera;
  WindowShape window;
  window.step = options_.window_step;
  window.half =
      std::clamp(options_.window_radius / options_.window_step, 1, (kMaxWindowSide - 1) / 2);
  problem.weights = PatchWeights(window, options_.sigma_spatial.value_or(options_.window_radius),
                                 options_.sigma_color * 255);
  const double reduction = std::pow(4.0, level);
  problem.noise_variance = static_cast<float>(
      std::max(kRoundingVariance, options_.noise_sigma * options_.noise_sigma / reduction));
  problem.weights.min_variance = kMinWindowToNoise * problem.noise_variance;
  problem.geometric_weight = static_cast<float>(options_.geom_consistency_regularizer);
  problem.geometric_max_px = static_cast<float>(options_.geom_consistency_max_cost);
  for (const int neighbor_idx : neighbor_idxs_) {
    AddSource(out.camera, neighbor_idx, level, &out);
    if (maps_ != nullptr) AddSourcePlanes(out.camera, neighbor_idx, &out);
  }
  return out;
}

// Inverse depths of the sparse points that the view sees (where these are few, of those in its
// image); every other pixel takes that of the nearest.
PlaneMap ViewMatcher::SeedPlanes(const PinholeCamera& camera) const {
  PlaneMap planes(camera.width, camera.height);
  const View& view = scene_.views[static_cast<size_t>(view_idx_)];
  std::deque<PixelPosition> front;
  for (const uint32_t p : SeedPoints()) {
    const Eigen::Vector3d x = view.cam_from_world * scene_.points[p].x_in_world;
    if (!(x.z() > 0)) continue;
    const Eigen::Vector2d x_px = camera.Project(x);
    if (!camera.Contains(x_px)) continue;
    const PixelPosition pixel{static_cast<int>(x_px.x()), static_cast<int>(x_px.y())};
    Plane& plane = planes(pixel.column, pixel.row);
    if (!(plane.q > 0)) front.push_back(pixel);
    plane.q = std::clamp(static_cast<float>(1 / x.z()), min_q_, max_q_);
  }
  for (; !front.empty(); front.pop_front()) {
    const auto [column, row] = front.front();
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (!planes.Inside(column + dx, row + dy) || planes(column + dx, row + dy).q > 0) continue;
      planes(column + dx, row + dy) = planes(column, row);
      front.push_back({column + dx, row + dy});
    }
  }
  return planes;
}

std::vector<uint32_t> ViewMatcher::SeedPoints() const {
  std::vector<uint32_t> point_idxs;
  for (size_t p = 0; p < scene_.points.size(); ++p) {
    const std::vector<int>& view_idxs = scene_.points[p].view_idxs;
    if (std::binary_search(view_idxs.begin(), view_idxs.end(), view_idx_)) {
      point_idxs.push_back(static_cast<uint32_t>(p));
    }
  }
  return point_idxs.size() < kMinPointsOfView ? PointsInImage(scene_, view_idx_) : point_idxs;
}

PlaneMap ViewMatcher::OwnPlanes() const {
  const auto map = maps_->Get(view_idx_);
  if (map == nullptr) return {};
  const View& view = scene_.views[static_cast<size_t>(view_idx_)];
  return ToPlaneMap(view.camera.Resized(map->depth.width, map->depth.height), *map);
}

void ViewMatcher::ApplyMask(int level, PlaneMap* planes) const {
  const auto mask = images_.Mask(view_idx_, level);
  if (mask == nullptr) return;
  for (size_t i = 0; i < planes->size(); ++i) {
    if (mask->pixels[i] == 0) planes->pixels[i] = {};
  }
}

void ViewMatcher::FilterByAngle(const PinholeCamera& camera, PlaneMap* planes) const {
  const View& view = scene_.views[static_cast<size_t>(view_idx_)];
  const double max_cosine =
      std::cos(options_.filter_min_triangulation_angle * std::numbers::pi / 180);
  std::vector<Eigen::Vector3d> centers;  // in the reference's camera frame
  for (const int neighbor_idx : neighbor_idxs_) {
    centers.push_back(view.cam_from_world *
                      scene_.views[static_cast<size_t>(neighbor_idx)].CenterInWorld());
  }
  for (int row = 0; row < planes->height; ++row) {
    for (int column = 0; column < planes->width; ++column) {
      Plane& plane = (*planes)(column, row);
      if (!(plane.q > 0)) continue;
      const Eigen::Vector3d x = camera.PixelRay(column, row) / plane.q;
      const bool wide = std::any_of(centers.begin(), centers.end(), [&](const auto& center) {
        return x.normalized().dot((x - center).normalized()) < max_cosine;
      });
      if (!wide) plane = {};
    }
  }
}

double ViewMatcher::MeanBaseline() const {
  const Eigen::Vector3d center = scene_.views[static_cast<size_t>(view_idx_)].CenterInWorld();
  double sum = 0;
  for (const int neighbor_idx : neighbor_idxs_) {
    sum += (scene_.views[static_cast<size_t>(neighbor_idx)].CenterInWorld() - center).norm();
  }
  return sum / static_cast<double>(neighbor_idxs_.size());
}

void ViewMatcher::FilterExtrapolation(const Level& level, PlaneMap* planes) const {
  const double displacement_px = level.camera.fx * MeanBaseline();  // of a unit of inverse depth
  const Raster<uint8_t> textured = TexturedPixels(
      *level.gray, kTextureRadius, kMinTextureToNoise * level.problem.noise_variance);
  const TexturelessFilterOptions settings = {
      .max_deviation = static_cast<float>(kMaxTexturelessBulgePx / displacement_px),
      .max_step = static_cast<float>(kMaxTexturelessStepPx / displacement_px),
      .border_reach = 2 * options_.window_radius + 1,
      .texture_radius = kTextureRadius};
  FilterTexturelessPixels(textured, settings, planes);
}

DepthMap ViewMatcher::Run(const RunContext& context) {
  const bool geometric = maps_ != nullptr;
  const int finest = geometric ? 0 : PhotometricLevel(options_);
  const bool filter = options_.filter && (geometric || !options_.geom_consistency);
  PlaneMap planes = geometric ? OwnPlanes() : PlaneMap();
  if (geometric && planes.empty()) return EmptyMap(0);
  const int coarsest = geometric ? PhotometricLevel(options_) : std::max(finest, CoarsestLevel());
  for (int l = coarsest; l >= finest; --l) {
    const Level level = MakeLevel(l);
    LevelMatcher matcher = MakeMatcher(level, l);
    const int num_views = l >= 2 ? options_.max_num_neighbors
                          : l == 1
                              ? (options_.max_num_neighbors + options_.max_num_fine_neighbors) / 2
                              : options_.max_num_fine_neighbors;
    if (planes.empty()) {
      matcher.Start(SeedPlanes(level.camera), num_views, context);
    } else {
      const bool same_size =
          planes.width == level.camera.width && planes.height == level.camera.height;
      const PlaneMap coarse = std::move(planes);
      matcher.Start(
          same_size ? coarse : ResizePlaneMap(coarse, level.camera.width, level.camera.height),
          num_views, context);
      if (!same_size) matcher.InheritNeighbors(coarse, context);
    }
    for (const SweepSettings& sweep : Schedule(l, l == coarsest, geometric, options_)) {
      matcher.Sweep(sweep, context);
    }
    if (l == finest && filter) {
      matcher.Filter(
          {static_cast<float>(options_.filter_min_ncc), options_.filter_min_num_consistent,
           static_cast<float>(options_.filter_geom_consistency_max_cost)},
          context);
    }
    planes = matcher.planes();
    if (l == finest) {
      ApplyMask(l, &planes);
      if (filter) {
        FilterByAngle(level.camera, &planes);
        FilterExtrapolation(level, &planes);
      }
    }
  }
  return ToDepthMap(images_.Camera(view_idx_, finest), planes);
}

}  // namespace

int PhotometricLevel(const PatchMatchOptions& options) { return options.geom_consistency ? 1 : 0; }

DepthMap EstimateDepthMap(const Scene& scene, const ImageStore& images, int view_idx,
                          const std::vector<Neighbor>& neighbors, const DepthRange& range,
                          const DepthMapSource* maps, const PatchMatchOptions& options,
                          const RunContext& context) {
  ViewMatcher matcher(scene, images, view_idx, neighbors, range, maps, options);
  if (!matcher.CanMatch()) return matcher.EmptyMap(maps != nullptr ? 0 : PhotometricLevel(options));
  return matcher.Run(context);
}

namespace {

// What a view of so many pixels holds while its finest level is matched.
double MatchingBytes(double num_pixels, int num_neighbors, const PatchMatchOptions& options) {
  // The level: planes and costs of the matcher, its choice of sources (a byte a source for each
  // tile of 32 pixels), a copy of the planes. Of each neighbour a cell image.
  constexpr double kLevel = 12 + 4 + 1 + 12, kCells = 4;
  double bytes = kLevel + kCells * num_neighbors;
  if (options.geom_consistency) {
    // At half the resolution: planes of the view and of its neighbours; the map that the last was
    // made from.
    bytes += (12.0 * (1 + num_neighbors) + 16) / 4;
  }
  // The maps that are written: depths and normals, twice, and one component on its own.
  constexpr double kWriting = 12 + 2 * 16 + 4;
  return num_pixels * std::max(bytes, kWriting);
}

// What is kept between the views: photos in grey with their levels, packed maps of the first pass.
double HeldBytes(double num_pixels, int num_views, int num_neighbors,
                 const PatchMatchOptions& options) {
  constexpr double kPhoto = 4 * 4.0 / 3, kPackedMap = PackedDepthMap::kBytesPerPixel / 4.0;
  // A view asks for photos before those of the view before are let go of.
  const double photos = std::min<double>(num_views, kViewsHeld + num_neighbors / 2.0);
  const double maps =
      options.geom_consistency ? std::min<double>(num_views, kViewsHeld) * kPackedMap : 0;
  return num_pixels * (kPhoto * photos + maps);
}

}  // namespace

CostEstimate EstimatePatchMatchCost(const Scene& scene, const ImageStore& images,
                                    const PatchMatchOptions& options) {
  CostEstimate cost;
  const double side = 2 * (options.window_radius / options.window_step) + 1;
  const double samples = std::min(side * side, double(kMaxWindowSamples));
  for (int v = 0; v < scene.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(v, 0);
    const double num_pixels = static_cast<double>(camera.width) * camera.height;
    cost.cpu_seconds +=
        num_pixels * (kWindowsPerPixel * samples * kSecondsPerSample + kSecondsPerPixel);
  }
  const auto largest = static_cast<double>(LargestImagePixels(images));
  const int num_neighbors = std::min(options.max_num_neighbors, scene.num_views() - 1);
  cost.peak_bytes =
      static_cast<size_t>(MatchingBytes(largest, num_neighbors, options) +
                          HeldBytes(largest, scene.num_views(), num_neighbors, options));
  return cost;
}

}  // namespace lsmvs
