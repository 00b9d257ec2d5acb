#include "lsmvs/stereo/fusion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "lsmvs/geometry/inverse_depth_transfer.h"
#include "lsmvs/image/largest_image.h"
#include "lsmvs/scene/center_groups.h"
#include "lsmvs/scene/packed_depth_map.h"
#include "lsmvs/stereo/fusion/evidence.h"
#include "lsmvs/stereo/fusion/loaded_view.h"
#include "lsmvs/stereo/fusion/speckle_filter.h"
#include "lsmvs/stereo/sampling/plane_map.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

// For the cost estimate, measured on 1536 x 1024 photos.
constexpr double kSecondsPerPixel = 0.45e-6;
// Also for it: views that agree on the points of a view without lower neighbours; its points per
// pixel; by how much vectors that grow are larger than what they hold.
constexpr double kViewsOfFirstPoints = 6, kPointsOfFirstView = 0.6, kGrowth = 1.4;
// A view sees through a point if its map lies so many times the thresholds behind it.
constexpr double kSeeThroughFactor = 2;
// Pixels of weak support must hang together over the area of a few matching windows: less repeats
// the evidence of one.
constexpr int kMinWeakArea = 121;

struct Thresholds {
  explicit Thresholds(const FusionOptions& options)
      : depth(options.max_depth_error),
        cos_normal(std::cos(options.max_normal_error * std::numbers::pi / 180)),
        reproj(options.max_reproj_error),
        weak_reproj(std::min(options.weak_max_reproj_error, options.max_reproj_error)) {}
  double depth, cos_normal, reproj, weak_reproj;
};

}  // namespace

void FusionOptions::Describe(OptionSet* options) {
  const auto name = [](const char* field) { return std::string("StereoFusion.") + field; };
  options->Add(
      name("min_num_pixels"), &min_num_pixels,
      "Minimum number of views that agree on a point; raising it gives a cleaner and sparser cloud",
      {1, 1000});
  options->Add(name("max_num_pixels"), &max_num_pixels,
               "Maximum number of views averaged into one point", {1, 1000000});
  options->Add(name("max_reproj_error"), &max_reproj_error,
               "Maximum forward-backward error [px] for a pixel to join a point", {0.0, 100.0});
  options->Add(name("max_depth_error"), &max_depth_error,
               "Maximum relative difference of depth for a pixel to join a point", {0.0, 1.0});
  options->Add(name("max_normal_error"), &max_normal_error,
               "Maximum angle [deg] between normals for a pixel to join a point", {0.0, 180.0});
  options->Add(name("weak_max_reproj_error"), &weak_max_reproj_error,
               "pixels of agreement with which one view less than min_num_pixels is enough, where "
               "no view sees through the point; 0: never",
               {0.0, 100.0});
  options->Add(name("check_num_images"), &check_num_images,
               "Maximum number of neighbours checked per reference view", {1, 1000});
}

namespace {

class Fuser {
 public:
  Fuser(const Scene& scene, const ImageStore& images,
        const std::vector<std::vector<Neighbor>>& neighbors, const DepthMapSource& maps,
        const FusionOptions& options);
  void Run(std::span<const int> view_idxs, const CloudSink& sink, const RunContext& context) const;

 private:
  LoadedView Load(int view_idx) const;
  // Whether two of the views, which GroupByPlace has put behind each other, are from one place.
  bool ShareAPlace(const std::vector<int>& view_idxs) const;
  void FuseView(int view_idx, const CloudSink& sink, const RunContext& context) const;
  void Collect(const LoadedView& reference, const LoadedView& neighbor, size_t slot,
               Evidence* evidence, const RunContext& context) const;
  Raster<uint8_t> Accept(const LoadedView& reference, const Evidence& evidence) const;
  VisibilityCloud FuseRow(const LoadedView& reference, int view_idx, const Raster<uint8_t>& support,
                          const Evidence& evidence, int row) const;

  const Scene& scene_;
  const ImageStore& images_;
  const DepthMapSource& maps_;
  const FusionOptions& options_;
  const Thresholds thresholds_;
  const size_t image_bytes_held_;
  const std::vector<int> places_;  // of each view, as CenterGroups
  const std::vector<std::vector<int>> neighbor_idxs_;
};

// The best of those that a view chose and those that chose it, by score. Cut to `limit`, so not
// symmetric: a much chosen view keeps its best ones only.
std::vector<std::vector<int>> RankedNeighbors(const std::vector<std::vector<Neighbor>>& lists,
                                              int limit) {
  std::vector<std::vector<std::pair<double, int>>> scored(lists.size());
  for (size_t a = 0; a < lists.size(); ++a) {
    for (const Neighbor& neighbor : lists[a]) {
      scored[a].push_back({-neighbor.score, neighbor.view_idx});
      scored[static_cast<size_t>(neighbor.view_idx)].push_back(
          {-neighbor.score, static_cast<int>(a)});
    }
  }
  std::vector<std::vector<int>> out(lists.size());
  for (size_t a = 0; a < lists.size(); ++a) {
    std::sort(scored[a].begin(), scored[a].end());
    for (const auto& [score, b] : scored[a]) {
      const bool known = std::find(out[a].begin(), out[a].end(), b) != out[a].end();
      if (!known && static_cast<int>(out[a].size()) < limit) out[a].push_back(b);
    }
  }
  return out;
}

// Views that may cover pixels come first: covered pixels are skipped from then on.
std::vector<std::vector<int>> LowerFirst(std::vector<std::vector<int>> lists) {
  for (size_t a = 0; a < lists.size(); ++a) {
    std::stable_partition(lists[a].begin(), lists[a].end(),
                          [&](int b) { return b < static_cast<int>(a); });
  }
  return lists;
}

// Leaves out views from the place of the reference, and puts those of one place behind each other.
std::vector<std::vector<int>> GroupByPlace(std::vector<std::vector<int>> lists,
                                           const std::vector<int>& places) {
  for (size_t a = 0; a < lists.size(); ++a) {
    std::vector<int>& list = lists[a];
    const auto place = [&](int v) { return places[static_cast<size_t>(v)]; };
    std::erase_if(list, [&](int v) { return place(v) == places[a]; });
    for (auto next = list.begin(); next != list.end();) {
      const int first = place(*next);
      next = std::stable_partition(next, list.end(), [&](int v) { return place(v) == first; });
    }
  }
  return lists;
}

// In the order in which a view is compared with them.
std::vector<std::vector<int>> NeighborsToFuse(const std::vector<std::vector<Neighbor>>& neighbors,
                                              int limit, const std::vector<int>& places) {
  return GroupByPlace(LowerFirst(RankedNeighbors(neighbors, limit)), places);
}

Fuser::Fuser(const Scene& scene, const ImageStore& images,
             const std::vector<std::vector<Neighbor>>& neighbors, const DepthMapSource& maps,
             const FusionOptions& options)
    : scene_(scene),
      images_(images),
      maps_(maps),
      options_(options),
      thresholds_(options),
      image_bytes_held_(kViewsHeld * LargestImagePixels(images) *
                        (sizeof(Color) + sizeof(uint8_t))),
      places_(CenterGroups(scene)),
      neighbor_idxs_(NeighborsToFuse(neighbors, options.check_num_images, places_)) {}

bool Fuser::ShareAPlace(const std::vector<int>& view_idxs) const {
  const auto same = [&](int a, int b) {
    return places_[static_cast<size_t>(a)] == places_[static_cast<size_t>(b)];
  };
  return std::adjacent_find(view_idxs.begin(), view_idxs.end(), same) != view_idxs.end();
}

LoadedView Fuser::Load(int view_idx) const {
  LoadedView loaded;
  loaded.view = &scene_.views[static_cast<size_t>(view_idx)];
  loaded.map = maps_.Get(view_idx);
  if (loaded.map == nullptr) return loaded;
  loaded.camera = loaded.view->camera.Resized(loaded.map->depth.width, loaded.map->depth.height);
  loaded.colors = images_.Colors(view_idx, 0);
  loaded.mask = images_.Mask(view_idx, 0);
  return loaded;
}

// Whether the point of the neighbour's pixel lies in a pixel of the reference.
bool LiesInPixel(const Eigen::Vector3d& x_in_reference, const PinholeCamera& camera, int column,
                 int row) {
  const Eigen::Vector2d x_px = camera.Project(x_in_reference);
  return std::floor(x_px.x()) == column && std::floor(x_px.y()) == row;
}

// Fills one slot of the evidence: what `neighbor` says about every pixel of `reference` that is not
// covered yet. A lower neighbour that agrees covers the pixel if its own point, at the centre of
// the pixel there, lies in the reference's pixel.
void Fuser::Collect(const LoadedView& reference, const LoadedView& neighbor, size_t slot,
                    Evidence* evidence, const RunContext& context) const {
  const Rigid3 neighbor_from_reference =
      neighbor.view->cam_from_world * reference.view->cam_from_world.Inverse();
  const Rigid3 reference_from_neighbor = neighbor_from_reference.Inverse();
  const Eigen::Matrix3d world_from_neighbor = neighbor.view->cam_from_world.rotation.transpose();
  const DepthMap& map = *neighbor.map;
  const int neighbor_place = places_[static_cast<size_t>(neighbor.view - scene_.views.data())];
  const bool is_lower = neighbor.view < reference.view;
  const auto visit = [&](int column, int row, size_t pixel) {
    const double depth = reference.map->depth.pixels[pixel];
    const Eigen::Vector3d ray = reference.camera.PixelRay(column, row);
    const Eigen::Vector3d x = neighbor_from_reference * (depth * ray);
    if (!(x.z() > 0)) return;
    const Eigen::Vector2d x_px = neighbor.camera.Project(x);
    if (!neighbor.camera.Contains(x_px)) return;
    const int to_column = static_cast<int>(x_px.x()), to_row = static_cast<int>(x_px.y());
    const double center_depth = map.depth(to_column, to_row);
    if (!(center_depth > 0) || neighbor.MaskedOut(to_column, to_row)) return;
    const Eigen::Vector3d normal = map.normal(to_column, to_row).cast<double>();
    // The neighbour's plane, at its pixel's centre, meets its ray through x and the reference's
    // ray.
    const Eigen::Vector3d center = center_depth * neighbor.camera.PixelRay(to_column, to_row);
    const double offset = normal.dot(center);
    const double seen_depth = offset / normal.dot(neighbor.camera.Ray(x_px));
    if (!(seen_depth > 0)) return;
    const Eigen::Vector3d seen = reference_from_neighbor * (seen_depth * neighbor.camera.Ray(x_px));
    const Eigen::Vector2d back_px = reference.camera.Project(seen);
    const double error_px = (back_px - Eigen::Vector2d(column + 0.5, row + 0.5)).norm();
    const double step = seen_depth - x.z();
    if (step > kSeeThroughFactor * thresholds_.depth * x.z() &&
        error_px > kSeeThroughFactor * thresholds_.reproj) {
      ++evidence->num_see_through[pixel];
    }
    if (std::abs(step) > thresholds_.depth * x.z() || error_px > thresholds_.reproj) return;
    const Eigen::Vector3d reference_normal =
        neighbor_from_reference.rotation * reference.map->normal.pixels[pixel].cast<double>();
    if (normal.dot(reference_normal) < thresholds_.cos_normal) return;
    const double along = normal.dot(neighbor_from_reference.rotation * ray);
    const double estimate = (offset - normal.dot(neighbor_from_reference.translation)) / along;
    if (!(std::abs(estimate - depth) <= 2 * thresholds_.depth * depth)) return;
    if (is_lower && LiesInPixel(reference_from_neighbor * center, reference.camera, column, row)) {
      evidence->is_covered[pixel] = 1;
      return;
    }
    RowEstimates& estimates = evidence->estimates[slot][static_cast<size_t>(row)];
    if (estimates.columns.empty()) {
      estimates.columns = PixelSet(static_cast<size_t>(reference.camera.width));
    }
    estimates.columns.Insert(static_cast<size_t>(column));
    estimates.depths.push_back(static_cast<float>(estimate));
    evidence->normal_sums[pixel] += (world_from_neighbor * normal).cast<float>();
    evidence->color_sums[pixel] += neighbor.ColorAt(to_column, to_row).cast<float>();
    evidence->Count(pixel, neighbor_place, error_px <= thresholds_.weak_reproj);
  };
  ParallelFor(context, static_cast<size_t>(reference.camera.height), 8, [&](size_t r) {
    const int row = static_cast<int>(r);
    for (int column = 0; column < reference.camera.width; ++column) {
      const size_t pixel = reference.map->depth.Index(column, row);
      if (reference.map->depth.pixels[pixel] > 0 && !evidence->is_covered[pixel]) {
        visit(column, row, pixel);
      }
    }
  });
}

// Mean of the values, weighted down with their distance from the median in units of the median
// distance.
double RobustMean(std::vector<float>* values) {
  std::sort(values->begin(), values->end());
  const size_t count = values->size();
  const double median = 0.5 * ((*values)[(count - 1) / 2] + (*values)[count / 2]);
  std::vector<double> distances;
  for (const float value : *values) distances.push_back(std::abs(value - median));
  std::sort(distances.begin(), distances.end());
  const double scale = std::max(2 * distances[count / 2], 1e-7 * std::abs(median));
  double sum = 0, sum_weights = 0;
  for (const float value : *values) {
    const double t = (value - median) / scale;
    const double weight = 1 / (1 + t * t);
    sum += weight * value;
    sum_weights += weight;
  }
  return sum / sum_weights;
}

// Pixels of the reference that become points: those with views enough, and those with one fewer
// that agree closely where no other view sees through them, as far as they hang together.
Raster<uint8_t> Fuser::Accept(const LoadedView& reference, const Evidence& evidence) const {
  const Raster<float>& depths = reference.map->depth;
  Raster<uint8_t> support(depths.width, depths.height, kNoSupport);
  for (size_t i = 0; i < support.size(); ++i) {
    if (!(depths.pixels[i] > 0)) continue;
    const int num_close = evidence.num_close[i];
    const bool weak = num_close > 0 && num_close + 2 >= options_.min_num_pixels &&
                      evidence.num_see_through[i] == 0;
    if (evidence.is_covered[i]) {
      support.pixels[i] = kCovered;
    } else if (1 + evidence.num_agree[i] >= options_.min_num_pixels) {
      support.pixels[i] = kSupported;
    } else if (weak && options_.weak_max_reproj_error > 0) {
      support.pixels[i] = kWeakSupport;
    }
  }
  FilterSpeckles(depths, options_.max_depth_error, kMinWeakArea, &support);
  return support;
}

VisibilityCloud Fuser::FuseRow(const LoadedView& reference, int view_idx,
                               const Raster<uint8_t>& support, const Evidence& evidence,
                               int row) const {
  VisibilityCloud points;
  const Rigid3 world_from_reference = reference.view->cam_from_world.Inverse();
  const std::vector<int>& neighbor_idxs = neighbor_idxs_[static_cast<size_t>(view_idx)];
  std::vector<float> depths;
  std::vector<uint32_t> views;
  std::vector<size_t> next(neighbor_idxs.size(), 0);  // estimate of each neighbour
  for (int column = 0; column < reference.camera.width; ++column) {
    const size_t pixel = reference.map->depth.Index(column, row);
    const float depth = reference.map->depth.pixels[pixel];
    depths.assign(1, depth);
    views.assign(1, static_cast<uint32_t>(view_idx));
    for (size_t slot = 0; slot < neighbor_idxs.size(); ++slot) {
      const RowEstimates& estimates = evidence.estimates[slot][static_cast<size_t>(row)];
      if (estimates.columns.empty() || !estimates.columns.Has(static_cast<size_t>(column)))
        continue;
      const float estimate = estimates.depths[next[slot]++];
      if (static_cast<int>(depths.size()) < options_.max_num_pixels) depths.push_back(estimate);
      views.push_back(static_cast<uint32_t>(neighbor_idxs[slot]));
    }
    const uint8_t kind = support.pixels[pixel];
    if (kind == kNoSupport || kind == kCovered || reference.MaskedOut(column, row)) continue;
    const Eigen::Vector3d x =
        world_from_reference * (RobustMean(&depths) * reference.camera.PixelRay(column, row));
    if (!options_.bounding_box.isEmpty() &&
        !options_.bounding_box.contains(Eigen::Vector3d(x + scene_.world_offset))) {
      continue;
    }
    const Eigen::Vector3f own_normal =
        world_from_reference.rotation.cast<float>() * reference.map->normal.pixels[pixel];
    const Eigen::Vector3f normal = (own_normal + evidence.normal_sums[pixel]).normalized();
    const Eigen::Vector3f color =
        (reference.ColorAt(column, row).cast<float>() + evidence.color_sums[pixel]) /
        static_cast<float>(views.size());
    points.Add(x.cast<float>(), normal, (color.array() + 0.5f).matrix().cast<uint8_t>(), views);
  }
  return points;
}

void Fuser::FuseView(int view_idx, const CloudSink& sink, const RunContext& context) const {
  const LoadedView reference = Load(view_idx);
  if (reference.map == nullptr) return;
  const std::vector<int>& neighbor_idxs = neighbor_idxs_[static_cast<size_t>(view_idx)];
  Evidence evidence(reference.map->depth.size(), neighbor_idxs.size(), reference.camera.height);
  if (ShareAPlace(neighbor_idxs)) {
    evidence.last_place.assign(reference.map->depth.size(), -1);
    evidence.last_close_place = evidence.last_place;
  }
  for (size_t slot = 0; slot < neighbor_idxs.size(); ++slot) {
    const LoadedView neighbor = Load(neighbor_idxs[slot]);
    if (neighbor.map == nullptr) continue;
    Collect(reference, neighbor, slot, &evidence, context);
    images_.Trim(image_bytes_held_);
  }
  const Raster<uint8_t> support = Accept(reference, evidence);
  std::vector<VisibilityCloud> rows(static_cast<size_t>(reference.camera.height));
  ParallelFor(context, rows.size(), 8, [&](size_t row) {
    rows[row] = FuseRow(reference, view_idx, support, evidence, static_cast<int>(row));
    // Points take the place of what they were made from.
    for (std::vector<RowEstimates>& of_neighbor : evidence.estimates) of_neighbor[row] = {};
  });
  for (const VisibilityCloud& row : rows) sink(row);
}

void Fuser::Run(std::span<const int> view_idxs, const CloudSink& sink,
                const RunContext& context) const {
  for (size_t i = 0; i < view_idxs.size(); ++i) {
    context.ThrowIfCancelled();
    FuseView(view_idxs[i], sink, context);
    context.Report(static_cast<double>(i + 1) / static_cast<double>(view_idxs.size()));
  }
}

}  // namespace

void FuseDepthMaps(const Scene& scene, const ImageStore& images,
                   const std::vector<std::vector<Neighbor>>& neighbors, const DepthMapSource& maps,
                   const FusionOptions& options, const CloudSink& sink, const RunContext& context) {
  std::vector<int> view_idxs(scene.views.size());
  std::iota(view_idxs.begin(), view_idxs.end(), 0);
  FuseViews(scene, images, neighbors, maps, view_idxs, options, sink, context);
}

void FuseViews(const Scene& scene, const ImageStore& images,
               const std::vector<std::vector<Neighbor>>& neighbors, const DepthMapSource& maps,
               std::span<const int> view_idxs, const FusionOptions& options, const CloudSink& sink,
               const RunContext& context) {
  RequireValid(options);
  LSMVS_CHECK(std::is_sorted(view_idxs.begin(), view_idxs.end()));
  Fuser(scene, images, neighbors, maps, options).Run(view_idxs, sink, context);
}

std::vector<std::vector<int>> FusionNeighbors(const Scene& scene,
                                              const std::vector<std::vector<Neighbor>>& neighbors,
                                              const FusionOptions& options) {
  return NeighborsToFuse(neighbors, options.check_num_images, CenterGroups(scene));
}

namespace {

// For one pixel of a view, that has all the others as neighbours.
double FusionBytesPerPixel(const Scene& scene, const FusionOptions& options) {
  const double num_views = scene.num_views();
  const double num_neighbors = std::min<double>(options.check_num_images, num_views - 1);
  const double num_held = std::min<double>(num_views, kViewsHeld);
  const double num_agreeing = std::min(num_neighbors, kViewsOfFirstPoints - 1);
  // Held: maps and photos; the maps of the reference and one neighbour, unpacked.
  const double held = num_held * (PackedDepthMap::kBytesPerPixel + sizeof(Color)) + 2 * 16;
  // Evidence: sums of normals and colours, three counts, whether it is covered; for each neighbour
  // a bit.
  const double evidence = 12 + 12 + 3 * 2 + 1 + num_neighbors / 8;
  // A depth of each neighbour that agrees, in vectors that have grown. Row by row the points of the
  // view take their place; of a view without lower neighbours none is covered: position, normal,
  // colour, views and where they begin.
  const double estimates = kGrowth * 4 * num_agreeing;
  const double points = kPointsOfFirstView * kGrowth * (12 + 12 + 3 + 8 + 4 * (1 + num_agreeing));
  const double support = 1;
  return held + evidence + std::max(estimates, points) + support;
}

}  // namespace

CostEstimate EstimateFusionCost(const Scene& scene, const ImageStore& images,
                                const FusionOptions& options) {
  CostEstimate cost;
  double total = 0;
  for (int v = 0; v < scene.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(v, 0);
    total += static_cast<double>(camera.width) * camera.height;
  }
  cost.cpu_seconds = total * kSecondsPerPixel;
  cost.peak_bytes = static_cast<size_t>(static_cast<double>(LargestImagePixels(images)) *
                                        FusionBytesPerPixel(scene, options));
  return cost;
}

}  // namespace lsmvs
