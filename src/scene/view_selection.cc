#include "lsmvs/scene/view_selection.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "lsmvs/geometry/triangulation.h"
#include "lsmvs/scene/points_by_view.h"
#include "lsmvs/scene/selection/same_sights.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
// Shared points are counted on a grid over the view: pairs whose overlap is a corner of the image
// score less.
constexpr int kCoverageCells = 8;
constexpr double kMaxFallbackAxisAngleDeg = 45.0;
// Angle between the axes at which a view counts as if it were twice as far away.
constexpr double kHalfScoreAxisAngleDeg = 15.0;
// Views with fewer neighbours by shared points than this get some by overlap.
constexpr int kEnoughNeighbors = 4;
// A point that a view sees is not hidden from another that looks at it from nearly the same side.
constexpr double kMaxSightAngleDeg = 60.0;
// Places that overlap is judged by, at most; part of them that two views must have in common.
constexpr size_t kMaxOverlapPlaces = 1000;
constexpr double kMinOverlap = 0.1;
// Views of its points that a view looks at, at most: where hundreds of views see a point, some of
// the points tell as much as all. Scenes of 10 to 100 photos have up to 50,000.
constexpr size_t kMaxLooks = 500'000;
// Photos that no feature ties together match at smaller angles only.
constexpr double kMaxOverlapAngleDeg = 50.0;

// What the sparse points that two views share say about the second as neighbour of the first.
struct PairStatistics {
  double score = 0;
  std::vector<float> angles_deg;
  std::bitset<kCoverageCells * kCoverageCells> cells;  // of the first view
};

int CoverageCell(const View& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector2d x = view.camera.Project(view.cam_from_world * x_in_world);
  const auto cell = [](double position, int size) {
    return std::clamp(static_cast<int>(position / size * kCoverageCells), 0, kCoverageCells - 1);
  };
  return cell(x.y(), view.camera.height) * kCoverageCells + cell(x.x(), view.camera.width);
}

double AngleWeight(double angle_deg, double best_deg) {
  const double ratio = std::min(angle_deg / best_deg, best_deg / std::max(angle_deg, 1e-9));
  return ratio * std::sqrt(ratio);
}

// Surface that a pixel covers where the point lies, world units; not positive behind the camera.
double PixelFootprint(const View& view, const SparsePoint& point) {
  return view.Depth(point.x_in_world) / view.camera.MeanFocalLength();
}

// What the points that a view sees say about the others, which are few of all.
class PairTable {
 public:
  explicit PairTable(size_t num_views) : place_of_view_(num_views, kNone) {}

  PairStatistics& Of(int view_idx) {
    uint32_t& place = place_of_view_[static_cast<size_t>(view_idx)];
    if (place == kNone) {
      place = static_cast<uint32_t>(pairs_.size());
      pairs_.emplace_back(view_idx, PairStatistics());
    }
    return pairs_[place].second;
  }
  // By ascending view; nothing can be added after that.
  std::vector<std::pair<int, PairStatistics>>& Sorted() {
    std::sort(pairs_.begin(), pairs_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    return pairs_;
  }

 private:
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> place_of_view_;
  std::vector<std::pair<int, PairStatistics>> pairs_;
};

// Adds what one point says about each other view that sees it.
void AddPoint(const Scene& scene, const std::vector<Eigen::Vector3d>& centers, double best_deg,
              int view_idx, const SparsePoint& point, PairTable* others) {
  const View& view = scene.views[view_idx];
  const double footprint = PixelFootprint(view, point);
  if (!(footprint > 0)) return;
  const size_t cell = static_cast<size_t>(CoverageCell(view, point.x_in_world));
  for (const int other : point.view_idxs) {
    const double other_footprint = PixelFootprint(scene.views[other], point);
    if (other == view_idx || !(other_footprint > 0)) continue;
    const double angle_deg =
        kDegreesPerRadian * TriangulationAngle(centers[view_idx], centers[other], point.x_in_world);
    PairStatistics& pair = others->Of(other);
    pair.score += AngleWeight(angle_deg, best_deg) *
                  std::min(footprint / other_footprint, other_footprint / footprint);
    pair.angles_deg.push_back(static_cast<float>(angle_deg));
    pair.cells.set(cell);
  }
}

// The other views that may be neighbours, in order. `stride`: of so many points one was added.
std::vector<Neighbor> UsableNeighbors(const ViewSelectionOptions& options, size_t stride,
                                      PairTable* others) {
  std::vector<Neighbor> neighbors;
  for (auto& [other, pair] : others->Sorted()) {
    const int num_shared = static_cast<int>(stride * pair.angles_deg.size());
    if (num_shared < options.min_num_shared_points) continue;
    const double angle_deg = Median(&pair.angles_deg);
    if (angle_deg < options.min_triangulation_angle_deg) continue;
    if (angle_deg > options.max_triangulation_angle_deg) continue;
    const double coverage =
        static_cast<double>(pair.cells.count()) / (kCoverageCells * kCoverageCells);
    neighbors.push_back(
        {other, static_cast<double>(stride) * pair.score * coverage, angle_deg, num_shared});
  }
  return neighbors;
}

// Adds neighbours below those that are there, with scores below theirs.
void Append(const std::vector<Neighbor>& found, std::vector<Neighbor>* neighbors) {
  if (found.empty()) return;
  const double limit = neighbors->empty() ? found.front().score : 0.5 * neighbors->back().score;
  const double scale = std::min(1.0, limit / found.front().score);
  for (Neighbor neighbor : found) {
    neighbor.score *= scale;
    neighbors->push_back(neighbor);
  }
}

// Of some candidates the best, of which no two show the same.
class DistinctSelector {
 public:
  DistinctSelector(const SameSights& sights, std::vector<Eigen::Vector3d> places)
      : sights_(sights), places_(std::move(places)) {}

  // Moves the best `count` candidates to `kept`, and to `repeats` those that show the same as a
  // better one from a place of their own.
  void Select(std::vector<Neighbor> candidates, int count, std::vector<Neighbor>* kept,
              std::vector<Neighbor>* repeats) const {
    std::sort(candidates.begin(), candidates.end(), [](const Neighbor& a, const Neighbor& b) {
      return a.score != b.score ? a.score > b.score : a.view_idx < b.view_idx;
    });
    std::vector<Neighbor> found;
    for (const Neighbor& candidate : candidates) {
      if (static_cast<int>(found.size()) >= count) break;
      const auto shows_the_same = [&](const Neighbor& n) { return ShowTheSame(candidate, n); };
      const bool repeats_one = std::any_of(kept->begin(), kept->end(), shows_the_same) ||
                               std::any_of(found.begin(), found.end(), shows_the_same);
      if (!repeats_one) {
        found.push_back(candidate);
      } else if (!StandsWhereOneStands(candidate, *kept) &&
                 !StandsWhereOneStands(candidate, found)) {
        repeats->push_back(candidate);
      }
    }
    Append(found, kept);
  }

 private:
  bool ShowTheSame(const Neighbor& a, const Neighbor& b) const {
    return sights_.ShowTheSame(places_, a.view_idx, b.view_idx);
  }
  bool StandsWhereOneStands(const Neighbor& a, const std::vector<Neighbor>& others) const {
    return std::any_of(others.begin(), others.end(), [&](const Neighbor& n) {
      return sights_.StandInOnePlace(a.view_idx, n.view_idx);
    });
  }

  const SameSights& sights_;
  const std::vector<Eigen::Vector3d> places_;  // of the surface that the view shows
};

// Finds neighbours of views that share too few points with others, by what both look at.
class OverlapSelector {
 public:
  OverlapSelector(const Scene& scene, const std::vector<Eigen::Vector3d>& centers,
                  const ViewSelectionOptions& options)
      : scene_(scene), centers_(centers), options_(options), ranges_(EstimateDepthRanges(scene)) {}

  // Adds to the neighbours by shared points, which stay first.
  void Complete(int view_idx, const DistinctSelector& selector,
                std::vector<Neighbor>* neighbors) const {
    PairTable others(scene_.views.size());
    const std::vector<SparsePoint> places = Places(view_idx);
    for (const SparsePoint& place : places) {
      AddPoint(scene_, centers_, options_.best_triangulation_angle_deg, view_idx, place, &others);
    }
    std::vector<Neighbor> found = UsableNeighbors(options_, 1, &others);
    std::erase_if(found, [&](const Neighbor& n) {
      const bool known = std::any_of(neighbors->begin(), neighbors->end(), [&](const auto& other) {
        return other.view_idx == n.view_idx;
      });
      return known || n.median_angle_deg > kMaxOverlapAngleDeg ||
             n.num_shared_points < kMinOverlap * static_cast<double>(places.size());
    });
    const int missing = std::min(kEnoughNeighbors, options_.max_num_neighbors) -
                        static_cast<int>(neighbors->size());
    for (Neighbor& neighbor : found) {
      neighbor.num_shared_points = 0;
      neighbor.by_overlap = true;
    }
    std::vector<Neighbor> repeats;  // of no use: they share too few points with the view as well
    selector.Select(std::move(found), missing, neighbors, &repeats);
  }

 private:
  // Where the surface that the view shows may lie, each with the views that look there.
  std::vector<SparsePoint> Places(int view_idx) const {
    std::vector<uint32_t> point_idxs = PointsInImage(scene_, view_idx);
    std::erase_if(point_idxs, [&](uint32_t p) { return !MaySee(view_idx, scene_.points[p]); });
    std::vector<SparsePoint> places;
    const size_t stride = point_idxs.size() / kMaxOverlapPlaces + 1;
    for (size_t i = 0; i < point_idxs.size(); i += stride) {
      places.push_back(PlaceAt(scene_.points[point_idxs[i]].x_in_world));
    }
    return places.size() < kMinPointsOfView ? GridPlaces(view_idx) : places;
  }

  std::vector<SparsePoint> GridPlaces(int view_idx) const {
    const View& view = scene_.views[static_cast<size_t>(view_idx)];
    const DepthRange& range = ranges_[static_cast<size_t>(view_idx)];
    std::vector<SparsePoint> places;
    if (!(range.min > 0)) return places;
    const double depth = std::sqrt(range.min * range.max);
    const Rigid3 world_from_cam = view.cam_from_world.Inverse();
    for (int k = 0; k < kCoverageCells * kCoverageCells; ++k) {
      const Eigen::Vector2d x_px((k % kCoverageCells + 0.5) * view.camera.width / kCoverageCells,
                                 (k / kCoverageCells + 0.5) * view.camera.height / kCoverageCells);
      places.push_back(PlaceAt(world_from_cam * (depth * view.camera.Ray(x_px))));
    }
    return places;
  }

  bool MaySee(int view_idx, const SparsePoint& point) const {
    if (!Holds(view_idx, point.x_in_world)) return false;
    return std::any_of(point.view_idxs.begin(), point.view_idxs.end(), [&](int other) {
      return kDegreesPerRadian * TriangulationAngle(centers_[static_cast<size_t>(view_idx)],
                                                    centers_[static_cast<size_t>(other)],
                                                    point.x_in_world) <
             kMaxSightAngleDeg;
    });
  }

  // In its image and within its range of depths.
  bool Holds(int view_idx, const Eigen::Vector3d& x_in_world) const {
    const View& view = scene_.views[static_cast<size_t>(view_idx)];
    const DepthRange& range = ranges_[static_cast<size_t>(view_idx)];
    const Eigen::Vector3d x = view.cam_from_world * x_in_world;
    return x.z() > 0 && x.z() >= range.min && x.z() <= range.max &&
           view.camera.Contains(view.camera.Project(x));
  }

  SparsePoint PlaceAt(const Eigen::Vector3d& x_in_world) const {
    SparsePoint place;
    place.x_in_world = x_in_world;
    for (int v = 0; v < scene_.num_views(); ++v) {
      if (scene_.views[static_cast<size_t>(v)].has_photo && Holds(v, x_in_world))
        place.view_idxs.push_back(v);
    }
    return place;
  }

  const Scene& scene_;
  const std::vector<Eigen::Vector3d>& centers_;
  const ViewSelectionOptions& options_;
  const std::vector<DepthRange> ranges_;
};

std::vector<Neighbor> NearestViews(const Scene& scene, const std::vector<Eigen::Vector3d>& centers,
                                   const SameSights& sights, int view_idx) {
  std::vector<Neighbor> neighbors;
  const Eigen::Vector3d axis = scene.views[view_idx].cam_from_world.rotation.row(2);
  for (int other = 0; other < scene.num_views(); ++other) {
    const double distance = (centers[other] - centers[view_idx]).norm();
    const double cosine = axis.dot(scene.views[other].cam_from_world.rotation.row(2).transpose());
    if (sights.StandInOnePlace(other, view_idx) || !scene.views[other].has_photo) continue;
    const double angle_deg = kDegreesPerRadian * std::acos(std::clamp(cosine, -1.0, 1.0));
    if (angle_deg > kMaxFallbackAxisAngleDeg) continue;
    const double turn = angle_deg / kHalfScoreAxisAngleDeg;
    neighbors.push_back({other, 1.0 / (distance * (1 + turn * turn)), 0.0, 0});
  }
  return neighbors;
}

// Some of the places that a view sees.
std::vector<Eigen::Vector3d> SeenPlaces(const Scene& scene, std::span<const uint32_t> point_idxs) {
  constexpr size_t kMaxPlaces = 64;
  const size_t stride = point_idxs.size() / kMaxPlaces + 1;
  std::vector<Eigen::Vector3d> places;
  for (size_t i = 0; i < point_idxs.size(); i += stride) {
    places.push_back(scene.points[point_idxs[i]].x_in_world);
  }
  return places;
}

class NeighborSelector {
 public:
  NeighborSelector(const Scene& scene, const ViewSelectionOptions& options,
                   const RunContext& context)
      : scene_(scene),
        options_(options),
        context_(context),
        sights_(scene, options.min_triangulation_angle_deg),
        points_(scene),
        any_shared_(
            std::any_of(scene.points.begin(), scene.points.end(),
                        [](const SparsePoint& point) { return point.view_idxs.size() > 1; })),
        neighbors_(scene.views.size()),
        repeats_(scene.views.size()) {
    for (const View& view : scene.views) centers_.push_back(view.CenterInWorld());
  }

  std::vector<std::vector<Neighbor>> Select() {
    ParallelFor(context_, neighbors_.size(), 1, [&](size_t v) {
      Selector(v).Select(Candidates(static_cast<int>(v)), options_.max_num_neighbors,
                         &neighbors_[v], &repeats_[v]);
    });
    if (any_shared_) CompleteByOverlap();
    for (size_t v = 0; v < neighbors_.size(); ++v) CompleteByRepeats(v);
    return std::move(neighbors_);
  }

 private:
  DistinctSelector Selector(size_t v) const {
    return {sights_, SeenPlaces(scene_, points_.Of(static_cast<int>(v)))};
  }

  std::vector<Neighbor> Candidates(int view_idx) const {
    if (!any_shared_) return NearestViews(scene_, centers_, sights_, view_idx);
    PairTable others(scene_.views.size());
    const auto points = points_.Of(view_idx);
    size_t num_looks = 0;
    for (const uint32_t p : points) num_looks += scene_.points[p].view_idxs.size();
    const size_t stride = num_looks / kMaxLooks + 1;
    for (size_t i = 0; i < points.size(); i += stride) {
      AddPoint(scene_, centers_, options_.best_triangulation_angle_deg, view_idx,
               scene_.points[points[i]], &others);
    }
    return UsableNeighbors(options_, stride, &others);
  }

  size_t NumMissing(size_t v) const {
    const auto enough = static_cast<size_t>(std::min(kEnoughNeighbors, options_.max_num_neighbors));
    return enough - std::min(enough, neighbors_[v].size());
  }

  void CompleteByOverlap() {
    std::vector<size_t> lonely;
    for (size_t v = 0; v < neighbors_.size(); ++v) {
      if (NumMissing(v) > 0) lonely.push_back(v);
    }
    if (lonely.empty()) return;
    const OverlapSelector selector(scene_, centers_, options_);
    ParallelFor(context_, lonely.size(), 1, [&](size_t i) {
      const size_t v = lonely[i];
      selector.Complete(static_cast<int>(v), Selector(v), &neighbors_[v]);
    });
  }

  void CompleteByRepeats(size_t v) {
    std::vector<Neighbor>& repeats = repeats_[v];
    repeats.resize(std::min(repeats.size(), NumMissing(v)));
    Append(repeats, &neighbors_[v]);
  }

  const Scene& scene_;
  const ViewSelectionOptions& options_;
  const RunContext& context_;
  const SameSights sights_;
  const PointsByView points_;
  const bool any_shared_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<std::vector<Neighbor>> neighbors_, repeats_;
};

}  // namespace

void ViewSelectionOptions::Describe(OptionSet* options) {
  options->Add("ViewSelection.max_num_neighbors", &max_num_neighbors,
               "Number of neighbours kept per view; more take more time and help where surfaces "
               "are occluded",
               {1, 100});
  options->Add("ViewSelection.min_triangulation_angle", &min_triangulation_angle_deg,
               "Minimum median triangulation angle of a pair [deg]; smaller ones give no depth",
               {0.0, 90.0});
  options->Add("ViewSelection.max_triangulation_angle", &max_triangulation_angle_deg,
               "Maximum median triangulation angle of a pair [deg]; larger ones look too different",
               {0.0, 180.0});
  options->Add("ViewSelection.best_triangulation_angle", &best_triangulation_angle_deg,
               "Triangulation angle that matches best [deg]", {0.1, 90.0});
  options->Add("ViewSelection.min_num_shared_points", &min_num_shared_points,
               "Minimum number of sparse points that two views must share to be a pair",
               {1, 1000000});
}

std::vector<std::vector<Neighbor>> SelectNeighbors(const Scene& scene,
                                                   const ViewSelectionOptions& options,
                                                   const RunContext& context) {
  return NeighborSelector(scene, options, context).Select();
}

}  // namespace lsmvs
