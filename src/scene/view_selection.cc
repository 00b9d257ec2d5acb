#include "lsmvs/scene/view_selection.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "lsmvs/geometry/triangulation.h"

namespace lsmvs {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
// Shared points are counted on a grid over the view: pairs whose overlap is a corner of the image
// score less.
constexpr int kCoverageCells = 8;
constexpr double kMaxFallbackAxisAngleDeg = 45.0;

// What the sparse points say about one ordered pair (reference, neighbour).
struct PairStatistics {
  double score = 0;
  std::vector<float> angles_deg;
  std::bitset<kCoverageCells * kCoverageCells> cells;
};

int CoverageCell(const View& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector2d x = view.camera.Project(view.cam_from_world * x_in_world);
  const auto cell = [](double position, int size) {
    return std::clamp(static_cast<int>(position / size * kCoverageCells), 0, kCoverageCells - 1);
  };
  return cell(x.y(), view.camera.height) * kCoverageCells + cell(x.x(), view.camera.width);
}

double AngleWeight(double angle_deg, double best_deg) {
  return std::pow(std::min(angle_deg / best_deg, best_deg / std::max(angle_deg, 1e-9)), 1.5);
}

uint64_t PairKey(int a, int b) {
  return (static_cast<uint64_t>(a) << 32) | static_cast<uint32_t>(b);
}

using PairMap = std::unordered_map<uint64_t, PairStatistics>;

void AddPoint(const Scene& scene, const std::vector<Eigen::Vector3d>& centers,
              const ViewSelectionOptions& options, const SparsePoint& point, PairMap* pairs) {
  std::vector<double> gsds;
  std::vector<int> cells;
  for (const int v : point.view_idxs) {
    const View& view = scene.views[v];
    gsds.push_back(view.Depth(point.x_in_world) / view.camera.MeanFocalLength());
    cells.push_back(CoverageCell(view, point.x_in_world));
  }
  for (size_t i = 0; i < point.view_idxs.size(); ++i) {
    for (size_t j = i + 1; j < point.view_idxs.size(); ++j) {
      if (!(gsds[i] > 0) || !(gsds[j] > 0)) continue;
      const int a = point.view_idxs[i], b = point.view_idxs[j];
      const double angle_deg =
          kDegreesPerRadian * TriangulationAngle(centers[a], centers[b], point.x_in_world);
      const double weight = AngleWeight(angle_deg, options.best_triangulation_angle_deg) *
                            std::min(gsds[i] / gsds[j], gsds[j] / gsds[i]);
      for (const bool forward : {true, false}) {
        PairStatistics& pair = (*pairs)[forward ? PairKey(a, b) : PairKey(b, a)];
        pair.score += weight;
        pair.angles_deg.push_back(static_cast<float>(angle_deg));
        pair.cells.set(static_cast<size_t>(forward ? cells[i] : cells[j]));
      }
    }
  }
}

std::vector<Neighbor> NearestViews(const Scene& scene, const std::vector<Eigen::Vector3d>& centers,
                                   int view_idx) {
  std::vector<Neighbor> neighbors;
  const Eigen::Vector3d axis = scene.views[view_idx].cam_from_world.rotation.row(2);
  for (int other = 0; other < scene.num_views(); ++other) {
    const double distance = (centers[other] - centers[view_idx]).norm();
    const double cosine = axis.dot(scene.views[other].cam_from_world.rotation.row(2).transpose());
    if (other == view_idx || !(distance > 0)) continue;
    if (cosine < std::cos(kMaxFallbackAxisAngleDeg / kDegreesPerRadian)) continue;
    neighbors.push_back({other, 1.0 / distance, 0.0, 0});
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
                                                   const ViewSelectionOptions& options) {
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : scene.views) centers.push_back(view.CenterInWorld());
  PairMap pairs;
  for (const SparsePoint& point : scene.points) AddPoint(scene, centers, options, point, &pairs);

  std::vector<std::vector<Neighbor>> neighbors(scene.views.size());
  for (auto& [key, pair] : pairs) {
    const int num_shared = static_cast<int>(pair.angles_deg.size());
    const auto middle = pair.angles_deg.begin() + num_shared / 2;
    std::nth_element(pair.angles_deg.begin(), middle, pair.angles_deg.end());
    const double angle_deg = *middle;
    if (num_shared < options.min_num_shared_points) continue;
    if (angle_deg < options.min_triangulation_angle_deg) continue;
    if (angle_deg > options.max_triangulation_angle_deg) continue;
    const double coverage =
        static_cast<double>(pair.cells.count()) / (kCoverageCells * kCoverageCells);
    neighbors[key >> 32].push_back(
        {static_cast<int>(key & 0xffffffffu), pair.score * coverage, angle_deg, num_shared});
  }
  for (int v = 0; v < scene.num_views(); ++v) {
    if (pairs.empty()) neighbors[v] = NearestViews(scene, centers, v);
    KeepBest(&neighbors[v], options.max_num_neighbors);
  }
  return neighbors;
}

}  // namespace lsmvs
