#include "lsmvs/scene/view_selection.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

#include "lsmvs/geometry/triangulation.h"
#include "lsmvs/scene/center_groups.h"

namespace lsmvs {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
// Shared points are counted on a grid over the view: pairs whose overlap is a corner of the image
// score less.
constexpr int kCoverageCells = 8;
constexpr double kMaxFallbackAxisAngleDeg = 45.0;
// Angle between the axes at which a view counts as if it were twice as far away.
constexpr double kHalfScoreAxisAngleDeg = 15.0;

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

// Positions of the points that each view sees, view by view.
class PointsByView {
 public:
  explicit PointsByView(const Scene& scene) : begins_(scene.views.size() + 1, 0) {
    for (const SparsePoint& point : scene.points) {
      for (const int v : point.view_idxs) ++begins_[static_cast<size_t>(v) + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    point_idxs_.resize(begins_.back());
    std::vector<size_t> next = begins_;
    for (size_t p = 0; p < scene.points.size(); ++p) {
      for (const int v : scene.points[p].view_idxs) {
        point_idxs_[next[static_cast<size_t>(v)]++] = static_cast<uint32_t>(p);
      }
    }
  }
  std::span<const uint32_t> Of(int view_idx) const {
    const size_t v = static_cast<size_t>(view_idx);
    return std::span(point_idxs_).subspan(begins_[v], begins_[v + 1] - begins_[v]);
  }

 private:
  std::vector<size_t> begins_;
  std::vector<uint32_t> point_idxs_;
};

// Adds what one point says about each other view that sees it.
void AddPoint(const Scene& scene, const std::vector<Eigen::Vector3d>& centers, double best_deg,
              int view_idx, const SparsePoint& point, std::vector<PairStatistics>* others) {
  const View& view = scene.views[view_idx];
  const double footprint = PixelFootprint(view, point);
  if (!(footprint > 0)) return;
  const size_t cell = static_cast<size_t>(CoverageCell(view, point.x_in_world));
  for (const int other : point.view_idxs) {
    const double other_footprint = PixelFootprint(scene.views[other], point);
    if (other == view_idx || !(other_footprint > 0)) continue;
    const double angle_deg =
        kDegreesPerRadian * TriangulationAngle(centers[view_idx], centers[other], point.x_in_world);
    PairStatistics& pair = (*others)[static_cast<size_t>(other)];
    pair.score += AngleWeight(angle_deg, best_deg) *
                  std::min(footprint / other_footprint, other_footprint / footprint);
    pair.angles_deg.push_back(static_cast<float>(angle_deg));
    pair.cells.set(cell);
  }
}

// The other views that may be neighbours, in order.
std::vector<Neighbor> UsableNeighbors(const ViewSelectionOptions& options,
                                      std::vector<PairStatistics>* others) {
  std::vector<Neighbor> neighbors;
  for (size_t other = 0; other < others->size(); ++other) {
    PairStatistics& pair = (*others)[other];
    const int num_shared = static_cast<int>(pair.angles_deg.size());
    if (num_shared < options.min_num_shared_points) continue;
    const auto middle = pair.angles_deg.begin() + num_shared / 2;
    std::nth_element(pair.angles_deg.begin(), middle, pair.angles_deg.end());
    const double angle_deg = *middle;
    if (angle_deg < options.min_triangulation_angle_deg) continue;
    if (angle_deg > options.max_triangulation_angle_deg) continue;
    const double coverage =
        static_cast<double>(pair.cells.count()) / (kCoverageCells * kCoverageCells);
    neighbors.push_back({static_cast<int>(other), pair.score * coverage, angle_deg, num_shared});
  }
  return neighbors;
}

std::vector<Neighbor> NearestViews(const Scene& scene, const std::vector<Eigen::Vector3d>& centers,
                                   const std::vector<int>& places, int view_idx) {
  std::vector<Neighbor> neighbors;
  const Eigen::Vector3d axis = scene.views[view_idx].cam_from_world.rotation.row(2);
  for (int other = 0; other < scene.num_views(); ++other) {
    const double distance = (centers[other] - centers[view_idx]).norm();
    const double cosine = axis.dot(scene.views[other].cam_from_world.rotation.row(2).transpose());
    if (places[other] == places[view_idx] || !scene.views[other].has_photo) continue;
    const double angle_deg = kDegreesPerRadian * std::acos(std::clamp(cosine, -1.0, 1.0));
    if (angle_deg > kMaxFallbackAxisAngleDeg) continue;
    const double turn = angle_deg / kHalfScoreAxisAngleDeg;
    neighbors.push_back({other, 1.0 / (distance * (1 + turn * turn)), 0.0, 0});
  }
  return neighbors;
}

void KeepBest(std::vector<Neighbor>* neighbors, int count) {
  std::sort(neighbors->begin(), neighbors->end(), [](const Neighbor& a, const Neighbor& b) {
    return a.score != b.score ? a.score > b.score : a.view_idx < b.view_idx;
  });
  if (static_cast<int>(neighbors->size()) > count) neighbors->resize(static_cast<size_t>(count));
}

}  // namespace

void ViewSelectionOptions::Describe(OptionSet* options) {
  options->Add("ViewSelection.max_num_neighbors", &max_num_neighbors,
               "neighbours kept a view; more cost time and help where surfaces are occluded",
               {1, 100});
  options->Add("ViewSelection.min_triangulation_angle", &min_triangulation_angle_deg,
               "degrees; pairs with a smaller median angle give no depth", {0.0, 90.0});
  options->Add("ViewSelection.max_triangulation_angle", &max_triangulation_angle_deg,
               "degrees; pairs with a larger median angle look too different", {0.0, 180.0});
  options->Add("ViewSelection.best_triangulation_angle", &best_triangulation_angle_deg,
               "degrees; the angle that matches best", {0.1, 90.0});
  options->Add("ViewSelection.min_num_shared_points", &min_num_shared_points,
               "shared sparse points below which a pair is not trusted", {1, 1000000});
}

std::vector<std::vector<Neighbor>> SelectNeighbors(const Scene& scene,
                                                   const ViewSelectionOptions& options,
                                                   const RunContext& context) {
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : scene.views) centers.push_back(view.CenterInWorld());
  const std::vector<int> places = CenterGroups(scene);
  const PointsByView points(scene);
  const bool any_shared = std::any_of(scene.points.begin(), scene.points.end(),
                                      [](const auto& point) { return point.view_idxs.size() > 1; });
  std::vector<std::vector<Neighbor>> neighbors(scene.views.size());
  ParallelFor(context, neighbors.size(), 1, [&](size_t v) {
    const int view_idx = static_cast<int>(v);
    if (!any_shared) {
      neighbors[v] = NearestViews(scene, centers, places, view_idx);
    } else {
      std::vector<PairStatistics> others(scene.views.size());
      for (const uint32_t p : points.Of(view_idx)) {
        AddPoint(scene, centers, options.best_triangulation_angle_deg, view_idx, scene.points[p],
                 &others);
      }
      neighbors[v] = UsableNeighbors(options, &others);
    }
    KeepBest(&neighbors[v], options.max_num_neighbors);
  });
  return neighbors;
}

}  // namespace lsmvs
