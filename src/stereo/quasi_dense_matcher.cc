#include "lsmvs/stereo/quasi_dense_matcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "lsmvs/image/largest_image.h"
#include "lsmvs/stereo/quasi_dense/cross_check.h"
#include "lsmvs/stereo/quasi_dense/grid_store.h"
#include "lsmvs/stereo/quasi_dense/image_cache.h"
#include "lsmvs/stereo/quasi_dense/pairs.h"
#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/stereo/quasi_dense/search.h"
#include "lsmvs/stereo/quasi_dense/tracks.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

using namespace quasi_dense;

constexpr int kCoarsestLongerSide = 256;
constexpr int kSmallestSide = 24;  // pixels below which a scale is of no use
// Shares of the memory budget: one in so many.
constexpr size_t kBudgetShareOfImages = 5, kBudgetShareOfGrids = 5;

size_t ImageBudget(const ImageStore& images, const QuasiDenseOptions& options, size_t budget) {
  return std::min(budget / kBudgetShareOfImages,
                  kViewsHeld * sizeof(uint32_t) * LargestImagePixels(images, options.finest_level));
}
// Two stores live while mutual matches are looked for.
size_t GridBudget(const ImageStore& images, const QuasiDenseOptions& options, size_t budget) {
  const double pixels = static_cast<double>(LargestImagePixels(images, options.finest_level));
  const double points = pixels / (options.spacing_px * options.spacing_px);
  return std::min(budget / (2 * kBudgetShareOfGrids),
                  kViewsHeld * static_cast<size_t>(points * sizeof(InterestPoint)));
}

bool Usable(const DepthRange& range) { return range.min > 0 && range.max > range.min; }

std::vector<DepthRange> DepthRanges(const Scene& scene, const QuasiDenseOptions& options) {
  std::vector<DepthRange> ranges = EstimateDepthRanges(scene);
  for (DepthRange& range : ranges) {
    if (options.depth_min) range.min = *options.depth_min;
    if (options.depth_max) range.max = *options.depth_max;
  }
  return ranges;
}

int CoarsestLevel(const ImageStore& images, const QuasiDenseOptions& options) {
  int level = options.finest_level;
  for (size_t v = 0; v < images.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(static_cast<int>(v), 0);
    int needed = 0;
    while (std::max(camera.width, camera.height) >> needed >= kCoarsestLongerSide) ++needed;
    while (needed > 0 && std::min(camera.width, camera.height) >> needed < kSmallestSide) --needed;
    level = std::max(level, needed);
  }
  if (options.num_scales) level = options.finest_level + *options.num_scales - 1;
  return level;
}

// Scales are taken from coarse to fine. On each, every view gets interest points (Harris corners,
// difference-of-Gaussian blobs, the given keypoints) with controlled spacing. A point is searched
// along its epipolar segments in the neighbouring views at once: on the coarsest scale over the
// whole depth range with a fronto-parallel window, on finer ones around the planes that the points
// nearby on the coarser scale lie on. Windows are warped by the homography of that plane (to first
// order) and compared by ZNCC; the depth with the highest mean over the best views wins. A match
// stays if it is mutual: the interest point where it ends is matched back to where it came from.
// On the finest scale matches become tracks over all views that confirm them, with an observation
// of sub-pixel precision in each; a point is triangulated from the whole track and optimised under
// a robust loss (Ceres), then checked for reprojection error, angle and cheirality. A point of a
// later view that an earlier track covers makes no track of its own.
class Matcher {
 public:
  Matcher(const Scene& scene, const ImageStore& images,
          const std::vector<std::vector<Neighbor>>& neighbors,
          std::span<const std::vector<Eigen::Vector2f>> keypoints, const QuasiDenseOptions& options,
          QuasiDenseResult* result, const RunContext& context)
      : scene_(scene),
        images_(images),
        keypoints_(keypoints),
        options_(options),
        result_(result),
        context_(context),
        cells_(images, ImageBudget(images, options, context.memory_budget_bytes)),
        neighbors_(SymmetricNeighbors(neighbors, options.max_num_neighbors)),
        ranges_(DepthRanges(scene, options)),
        pattern_(MakeWindowPattern(options.window_radius)),
        grids_(NewGrids()) {}

  bool HasNeighbors() const {
    return std::any_of(neighbors_.begin(), neighbors_.end(),
                       [](const std::vector<int>& list) { return !list.empty(); });
  }
  bool HasDepthRange() const { return std::any_of(ranges_.begin(), ranges_.end(), Usable); }

  void Run(const CloudSink& sink) {
    const int coarsest = CoarsestLevel(images_, options_);
    // Each level costs about four times the one before; tracks about a third of the finest.
    double done = 0;
    const double scale = 0.75 * 0.75;
    for (int level = coarsest; level >= options_.finest_level; --level) {
      const double share = scale / std::pow(4.0, level - options_.finest_level);
      MatchLevel(level, level == coarsest, context_.Part(done, std::min(done + share, 0.75)));
      done = std::min(done + share, 0.75);
    }
    MakeAllTracks(sink, context_.Part(0.75, 1.0));
  }

 private:
  bool Active(int view_idx) const {
    return !neighbors_[static_cast<size_t>(view_idx)].empty() &&
           Usable(ranges_[static_cast<size_t>(view_idx)]);
  }

  void MatchLevel(int level, bool coarsest, const RunContext& context) {
    const int num_views = scene_.num_views();
    for (int v = 0; v < num_views; ++v) {
      if (Active(v)) MatchView(v, level, coarsest);
      TrimToViewsHeld(images_);
      context.Report((v + 1.0) / num_views);
    }
    KeepMutual(level);
  }

  void MatchView(int view_idx, int level, bool coarsest) {
    PointGrid grid = Detect(view_idx, level);
    const SearchView view = MakeSearchView(view_idx, level);
    const PhaseTimer timer("search", &result_->seconds);
    size_t& num_patches = result_->counters.num_patches;
    if (coarsest) {
      num_patches += SearchRange(view, context_, &grid);
      num_patches += Propagate(view, context_, &grid);
    } else {
      num_patches += SearchFromCoarser(view, *grids_->Get(view_idx), LevelScale(view_idx, level),
                                       context_, &grid);
    }
    num_patches += Propagate(view, context_, &grid);
    grids_->Put(view_idx, std::move(grid));
  }

  std::unique_ptr<GridStore> NewGrids() const {
    return std::make_unique<GridStore>(scene_.views.size(),
                                       GridBudget(images_, options_, context_.memory_budget_bytes));
  }

  NeighborGrids GridsAround(int view_idx, const std::vector<Pairing>& pairings) {
    NeighborGrids grids{grids_->Get(view_idx), {}};
    for (const Pairing& pairing : pairings) grids.others.push_back(grids_->Get(pairing.view_idx));
    return grids;
  }

  // Image coordinates of a level over those of the next coarser one.
  Eigen::Vector2f LevelScale(int view_idx, int level) const {
    const PinholeCamera fine = images_.Camera(view_idx, level);
    const PinholeCamera coarse = images_.Camera(view_idx, level + 1);
    return {static_cast<float>(fine.width) / static_cast<float>(coarse.width),
            static_cast<float>(fine.height) / static_cast<float>(coarse.height)};
  }

  PointGrid Detect(int view_idx, int level) {
    const PhaseTimer timer("detect", &result_->seconds);
    const auto gray = images_.Gray(view_idx, level);
    const auto mask = images_.Mask(view_idx, level);
    const DetectionOptions detection{static_cast<float>(options_.spacing_px),
                                     static_cast<float>(options_.noise_sigma),
                                     options_.window_radius + 1};
    PointGrid grid = DetectInterestPoints(*gray, mask.get(), detection, context_);
    if (level == options_.finest_level && !keypoints_.empty()) {
      const PinholeCamera& full = scene_.views[static_cast<size_t>(view_idx)].camera;
      const Eigen::Vector2f scale(
          static_cast<float>(gray->width) / static_cast<float>(full.width),
          static_cast<float>(gray->height) / static_cast<float>(full.height));
      result_->counters.num_joined_keypoints +=
          JoinKeypoints(keypoints_[static_cast<size_t>(view_idx)], scale,
                        {gray->width, gray->height}, mask.get(), detection, &grid);
    }
    if (level == options_.finest_level) {
      result_->counters.num_interest_points += static_cast<size_t>(
          std::count_if(grid.cells.pixels.begin(), grid.cells.pixels.end(),
                        [](const InterestPoint& point) { return point.exists(); }));
    }
    return grid;
  }

  SearchView MakeSearchView(int view_idx, int level) {
    const PhaseTimer timer("images", &result_->seconds);
    const std::vector<int>& neighbors = neighbors_[static_cast<size_t>(view_idx)];
    const DepthRange& range = ranges_[static_cast<size_t>(view_idx)];
    SearchView view;
    view.image = cells_.Get(view_idx, level);
    view.pairings = MakePairings(scene_, images_, level, view_idx, neighbors);
    for (const int other : neighbors) view.others.push_back(cells_.Get(other, level));
    view.pattern = pattern_;
    view.min_inverse_depth = static_cast<float>(1.0 / range.max);
    view.max_inverse_depth = static_cast<float>(1.0 / range.min);
    view.num_searched = options_.max_num_neighbors;
    view.num_compared = level == options_.finest_level ? options_.max_num_fine_neighbors
                                                       : options_.max_num_neighbors;
    view.min_ncc = static_cast<float>(options_.min_ncc);
    return view;
  }

  // Takes the matches of points that no neighbour confirms. All views are judged before any match
  // goes.
  void KeepMutual(int level) {
    const PhaseTimer timer("mutual check", &result_->seconds);
    std::unique_ptr<GridStore> kept = NewGrids();
    for (int v = 0; v < scene_.num_views(); ++v) {
      if (!Active(v)) continue;
      const std::vector<Pairing> pairings =
          MakePairings(scene_, images_, level, v, neighbors_[static_cast<size_t>(v)]);
      const NeighborGrids around = GridsAround(v, pairings);
      const Raster<uint32_t> confirmed = ConfirmedSlots(
          around, pairings, static_cast<float>(options_.max_mutual_error_px), context_);
      PointGrid grid = *around.own;
      for (size_t cell = 0; cell < confirmed.size(); ++cell) {
        InterestPoint& point = grid.cells.pixels[cell];
        if (!point.matched()) continue;
        if (level == options_.finest_level) ++result_->counters.num_matched;
        if (confirmed.pixels[cell] == 0) point.plane = Plane();
      }
      kept->Put(v, std::move(grid));
    }
    grids_ = std::move(kept);
  }

  void MakeAllTracks(const CloudSink& sink, const RunContext& context) {
    TrackWorld world{scene_, options_, {}, {}, {}};
    world.covered.resize(scene_.views.size());
    for (int v = 0; v < scene_.num_views(); ++v) {
      world.cameras.push_back(images_.Camera(v, options_.finest_level));
      world.projections.push_back(MakeProjectionMatrix(
          scene_.views[static_cast<size_t>(v)].cam_from_world, world.cameras.back()));
    }
    for (int v = 0; v < scene_.num_views(); ++v) {
      if (Active(v)) {
        const SearchView view = MakeSearchView(v, options_.finest_level);
        const PhaseTimer timer("tracks", &result_->seconds);
        const VisibilityCloud part = MakeTracks(v, view, GridsAround(v, view.pairings),
                                                *images_.Colors(v, options_.finest_level), context_,
                                                &world, &result_->counters);
        result_->num_points += part.size();
        result_->num_observations += part.view_idxs.size();
        if (part.size() > 0) sink(part);
        TrimToViewsHeld(images_);
      }
      context.Report((v + 1.0) / scene_.num_views());
    }
  }

  const Scene& scene_;
  const ImageStore& images_;
  std::span<const std::vector<Eigen::Vector2f>> keypoints_;
  const QuasiDenseOptions& options_;
  QuasiDenseResult* result_;
  const RunContext& context_;
  PackedImageCache cells_;
  std::vector<std::vector<int>> neighbors_;
  std::vector<DepthRange> ranges_;
  WindowPattern pattern_;
  std::unique_ptr<GridStore> grids_;  // of the last level that was matched
};

void Finish(QuasiDenseStatus status, const std::string& message, QuasiDenseResult* result) {
  result->status = status;
  result->message = message;
}

}  // namespace

QuasiDenseResult MatchQuasiDense(const Scene& scene, const ImageStore& images,
                                 const std::vector<std::vector<Neighbor>>& neighbors,
                                 std::span<const std::vector<Eigen::Vector2f>> keypoints,
                                 const QuasiDenseOptions& options, const CloudSink& sink,
                                 const RunContext& context) {
  RequireValid(options);
  LSMVS_CHECK_EQ(neighbors.size(), scene.views.size());
  LSMVS_CHECK_EQ(images.num_views(), scene.views.size());
  LSMVS_CHECK(keypoints.empty() || keypoints.size() == scene.views.size());
  QuasiDenseResult result;
  Matcher matcher(scene, images, neighbors, keypoints, options, &result, context);
  if (!matcher.HasNeighbors()) {
    Finish(QuasiDenseStatus::kNoNeighbors, "no two views overlap: nothing to match", &result);
  } else if (!matcher.HasDepthRange()) {
    Finish(QuasiDenseStatus::kNoDepthRange,
           "no sparse point before any camera: the depth range is unknown", &result);
  } else {
    matcher.Run(sink);
    if (result.num_points == 0) {
      Finish(QuasiDenseStatus::kNoMatches, "no interest point has a match in another view",
             &result);
    } else {
      result.message =
          fmt::format("{} points from {} interest points in {} views", result.num_points,
                      result.counters.num_interest_points, scene.views.size());
    }
  }
  context.Report(1.0);
  return result;
}

CostEstimate EstimateQuasiDenseCost(const Scene& scene, const ImageStore& images,
                                    const QuasiDenseOptions& options) {
  // Measured: windows compared an interest point on the finest scale (coarser ones add a third),
  // and what a sample costs.
  constexpr double kSecondsPerSample = 2.0e-9;
  constexpr double kTrialsPerPoint = 12, kCoarserScales = 4.0 / 3.0;
  constexpr double kSecondsPerPixel = 1.2e-7;  // detection and decoding
  // A reference's photo with its scales and its search; the tracks of one view.
  constexpr double kBytesPerPixel = 30, kBytesPerTrack = 80;
  const double samples = (2.0 * options.window_radius + 1) * (2.0 * options.window_radius + 1);
  double pixels = 0;
  for (int v = 0; v < scene.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(v, options.finest_level);
    pixels += static_cast<double>(camera.width) * camera.height;
  }
  const double points = pixels / (options.spacing_px * options.spacing_px);
  CostEstimate cost;
  cost.cpu_seconds = kCoarserScales * (pixels * kSecondsPerPixel +
                                       points * kTrialsPerPoint * options.max_num_fine_neighbors *
                                           samples * kSecondsPerSample);
  const double largest = static_cast<double>(LargestImagePixels(images, options.finest_level));
  const double views_held = std::min(static_cast<double>(kViewsHeld), double(scene.num_views()));
  const double points_of_view = largest / (options.spacing_px * options.spacing_px);
  cost.peak_bytes = static_cast<size_t>(
      views_held * (largest * sizeof(uint32_t) + 2 * points_of_view * sizeof(InterestPoint)) +
      points_of_view * kBytesPerTrack + largest * kBytesPerPixel + points / 8);
  return cost;
}

}  // namespace lsmvs
