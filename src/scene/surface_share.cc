#include "lsmvs/scene/surface_share.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace lsmvs {

namespace {

constexpr int kCellsOfLongerSide = 24;
constexpr double kMaxDistanceInCells = 2.0, kMaxAngleDeg = 60.0;
constexpr size_t kMaxLooks = 2'000'000;  // of a view at a cell's place
constexpr size_t kMinViews = 20;
// What is hidden counts as seen, and gaps between points as surface: measured on five scenes.
constexpr double kCalibration = 0.7;

struct CellGrid {
  explicit CellGrid(const PinholeCamera& camera)
      : side(std::max(camera.width, camera.height) / static_cast<double>(kCellsOfLongerSide)),
        columns(std::max(1, static_cast<int>(camera.width / side + 0.5))),
        rows(std::max(1, static_cast<int>(camera.height / side + 0.5))) {}

  Eigen::Vector2d Middle(int column, int row) const {
    return {(column + 0.5) * side, (row + 0.5) * side};
  }

  double side;  // pixels
  int columns, rows;
};

// Finds the surface in the photos' cells and how many photos show it.
class ShareEstimator {
 public:
  explicit ShareEstimator(const Scene& scene)
      : scene_(scene), stride_(StrideOf(scene.views.size())), seen_(scene.views.size()) {
    for (const View& view : scene.views) centers_.push_back(view.CenterInWorld());
    for (const SparsePoint& point : scene.points) {
      for (const int v : point.view_idxs) {
        if (static_cast<size_t>(v) % stride_ == 0) seen_[static_cast<size_t>(v)].push_back(&point);
      }
    }
  }

  SurfaceShare Run() const {
    Sums sums;
    double pixels = 0;
    for (size_t v = 0; v < scene_.views.size(); v += stride_) {
      const PinholeCamera& camera = scene_.views[v].camera;
      AddView(v, &sums);
      pixels += static_cast<double>(camera.width) * camera.height;
    }
    if (!(sums.once > 0)) return {};
    return {sums.covered / pixels, kCalibration * sums.once / pixels};
  }

 private:
  struct Sums {
    double covered = 0, once = 0;  // pixels
  };

  // From a view that is looked at to the next.
  static size_t StrideOf(size_t num_views) {
    constexpr size_t kCells = kCellsOfLongerSide * kCellsOfLongerSide;
    const size_t count = std::max(kMinViews, kMaxLooks / (kCells * num_views + 1));
    return std::max<size_t>(1, (num_views + count - 1) / count);
  }

  void AddView(size_t v, Sums* sums) const {
    const View& view = scene_.views[v];
    const CellGrid grid(view.camera);
    const std::vector<double> depths = CellDepths(v, grid);
    const Rigid3 world_from_cam = view.cam_from_world.Inverse();
    const double cell_pixels = grid.side * grid.side;
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        const double depth = depths[static_cast<size_t>(row * grid.columns + column)];
        if (!(depth > 0)) continue;
        sums->covered += cell_pixels;
        sums->once +=
            cell_pixels *
            Part(v, depth, world_from_cam * (depth * view.camera.Ray(grid.Middle(column, row))));
      }
    }
  }

  // Depth of the point nearest to each cell's middle; 0 where none is near.
  std::vector<double> CellDepths(size_t v, const CellGrid& grid) const {
    const View& view = scene_.views[v];
    const auto num_cells = static_cast<size_t>(grid.columns * grid.rows);
    std::vector<double> depths(num_cells, 0.0);
    std::vector<double> distances(num_cells, kMaxDistanceInCells * grid.side);
    constexpr int kReach = static_cast<int>(kMaxDistanceInCells);
    for (const SparsePoint* point : seen_[v]) {
      const Eigen::Vector3d x = view.cam_from_world * point->x_in_world;
      const Eigen::Vector2d x_px = view.camera.Project(x);
      if (!(x.z() > 0) || !view.camera.Contains(x_px)) continue;
      const int column = static_cast<int>(x_px.x() / grid.side),
                row = static_cast<int>(x_px.y() / grid.side);
      for (int r = std::max(0, row - kReach); r <= std::min(grid.rows - 1, row + kReach); ++r) {
        for (int c = std::max(0, column - kReach); c <= std::min(grid.columns - 1, column + kReach);
             ++c) {
          const auto cell = static_cast<size_t>(r * grid.columns + c);
          const double distance = (grid.Middle(c, r) - x_px).norm();
          if (distance >= distances[cell]) continue;
          distances[cell] = distance;
          depths[cell] = x.z();
        }
      }
    }
    return depths;
  }

  // What a pixel of a view counts that shows a place: finer photos have more pixels of it.
  double Part(size_t v, double depth, const Eigen::Vector3d& x_in_world) const {
    static const double min_cosine = std::cos(kMaxAngleDeg * std::numbers::pi / 180);
    const double size = depth / scene_.views[v].camera.MeanFocalLength();
    const Eigen::Vector3d direction = (x_in_world - centers_[v]).normalized();
    double finest = size;
    int num_views = 0;
    for (size_t other = 0; other < scene_.views.size(); ++other) {
      const View& view = scene_.views[other];
      if (!view.has_photo) continue;
      const Eigen::Vector3d x = view.cam_from_world * x_in_world;
      if (!(x.z() > 0)) continue;
      if (other != v) {
        if (!view.camera.Contains(view.camera.Project(x))) continue;
        if (direction.dot((x_in_world - centers_[other]).normalized()) < min_cosine) continue;
      }
      ++num_views;
      finest = std::min(finest, x.z() / view.camera.MeanFocalLength());
    }
    const double ratio = size / finest;
    return num_views == 0 ? 0.0 : ratio * ratio / num_views;
  }

  const Scene& scene_;
  const size_t stride_;
  std::vector<std::vector<const SparsePoint*>> seen_;  // by view, of those that are looked at
  std::vector<Eigen::Vector3d> centers_;
};

}  // namespace

SurfaceShare EstimateSurfaceShare(const Scene& scene) { return ShareEstimator(scene).Run(); }

}  // namespace lsmvs
