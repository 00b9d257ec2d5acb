#include "lsmvs/evaluation/silhouettes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lsmvs/image/raster.h"

namespace lsmvs {

namespace {

constexpr size_t kMinPixels = 100;
constexpr double kLargestHole = 0.05, kClosingShare = 0.01;
constexpr int kNormalRadius = 4;

using Mask = Raster<uint8_t>;
using Normals = Raster<Eigen::Vector3f>;

struct Silhouette {
  Mask covered;
  Normals normals;  // towards the camera; zero where nothing is
};

Silhouette Look(const MeshTracer& tracer, const TriangleMesh& mesh, const View& view,
                double reduction) {
  const int width = static_cast<int>(view.camera.width / reduction),
            height = static_cast<int>(view.camera.height / reduction);
  Silhouette result{Mask(width, height, 0), Normals(width, height, Eigen::Vector3f::Zero())};
  const Eigen::Matrix3d world_from_cam = view.cam_from_world.rotation.transpose();
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const Eigen::Vector2d x_px((column + 0.5) * reduction, (row + 0.5) * reduction);
      const Eigen::Vector3d ray = world_from_cam * view.camera.Ray(x_px);
      const auto hit = tracer.Cast(view.CenterInWorld(), ray);
      if (!hit) continue;
      const Eigen::Vector3d normal =
          FaceNormalTimesTwiceArea(mesh, static_cast<size_t>(hit->face)).normalized();
      result.covered(column, row) = 1;
      result.normals(column, row) = (normal.dot(ray) > 0 ? -normal : normal).cast<float>();
    }
  }
  return result;
}

size_t Count(const Mask& mask) {
  return static_cast<size_t>(std::count(mask.pixels.begin(), mask.pixels.end(), 1));
}

// Background in parts (connected over sides) that do not touch the border of the picture.
size_t CountHolePixels(const Mask& covered) {
  Mask seen = covered;
  size_t total = 0;
  std::vector<std::pair<int, int>> stack;
  for (int start = 0; start < static_cast<int>(seen.pixels.size()); ++start) {
    if (seen.pixels[static_cast<size_t>(start)]) continue;
    size_t count = 0;
    bool touches_border = false;
    const auto visit = [&](int column, int row) {
      if (column < 0 || row < 0 || column >= seen.width || row >= seen.height) {
        touches_border = true;
      } else if (!seen(column, row)) {
        seen(column, row) = 1;
        stack.emplace_back(column, row);
      }
    };
    visit(start % seen.width, start / seen.width);
    while (!stack.empty()) {
      const auto [column, row] = stack.back();
      stack.pop_back();
      ++count;
      visit(column - 1, row);
      visit(column + 1, row);
      visit(column, row - 1);
      visit(column, row + 1);
    }
    const bool is_small =
        static_cast<double>(count) < kLargestHole * covered.width * covered.height;
    if (!touches_border && is_small) total += count;
  }
  return total;
}

// Pixels that have a pixel of `value` within the disc become `value`. What lies outside does not
// count.
Mask Spread(const Mask& mask, int radius, uint8_t value) {
  Mask result = mask;
  for (int row = 0; row < mask.height; ++row) {
    for (int column = 0; column < mask.width; ++column) {
      if (mask(column, row) != value) continue;
      for (int dy = -radius; dy <= radius; ++dy) {
        const int reach = static_cast<int>(std::lround(std::sqrt(radius * radius - dy * dy)));
        if (row + dy < 0 || row + dy >= mask.height) continue;
        const int begin = std::max(0, column - reach),
                  end = std::min(mask.width - 1, column + reach);
        for (int k = begin; k <= end; ++k) result(k, row + dy) = value;
      }
    }
  }
  return result;
}

// Background that a closing by a disc fills; beyond the border of the picture all goes on as it is.
size_t CountTornPixels(const Mask& covered) {
  const int radius = std::max(1, static_cast<int>(kClosingShare * covered.width));
  const int margin = 2 * radius + 1;
  Mask wide(covered.width + 2 * margin, covered.height + 2 * margin, 0);
  for (int row = 0; row < wide.height; ++row) {
    for (int column = 0; column < wide.width; ++column) {
      wide(column, row) = covered(std::clamp(column - margin, 0, covered.width - 1),
                                  std::clamp(row - margin, 0, covered.height - 1));
    }
  }
  const Mask closed = Spread(Spread(wide, radius, 1), radius, 0);
  size_t count = 0;
  for (int row = 0; row < covered.height; ++row) {
    for (int column = 0; column < covered.width; ++column) {
      count += closed(column + margin, row + margin) && !covered(column, row);
    }
  }
  return count;
}

size_t CountRim(const Mask& covered) {
  size_t count = 0;
  for (int row = 0; row < covered.height; ++row) {
    for (int column = 0; column < covered.width; ++column) {
      if (column > 0) count += covered(column, row) != covered(column - 1, row);
      if (row > 0) count += covered(column, row) != covered(column, row - 1);
    }
  }
  return count;
}

// Mirrored at the border of the picture.
int Inside(int k, int size) {
  if (k < 0) k = -k;
  if (k >= size) k = 2 * size - 2 - k;
  return std::clamp(k, 0, size - 1);
}

size_t CountCrumbs(const Silhouette& silhouette) {
  const Normals& normals = silhouette.normals;
  size_t count = 0;
  for (int row = 0; row < normals.height; ++row) {
    for (int column = 0; column < normals.width; ++column) {
      if (!silhouette.covered(column, row)) continue;
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int dy = -kNormalRadius; dy <= kNormalRadius; ++dy) {
        for (int dx = -kNormalRadius; dx <= kNormalRadius; ++dx) {
          sum += normals(Inside(column + dx, normals.width), Inside(row + dy, normals.height));
        }
      }
      count += normals(column, row).dot(sum) < std::sqrt(0.5f) * sum.norm();
    }
  }
  return count;
}

SilhouetteFigures Measure(const Silhouette& silhouette) {
  const size_t num_covered = Count(silhouette.covered);
  SilhouetteFigures figures;
  if (num_covered < kMinPixels) return figures;
  const double area = static_cast<double>(num_covered);
  figures.num_views = 1;
  figures.coverage = area / static_cast<double>(silhouette.covered.pixels.size());
  figures.hole_share = static_cast<double>(CountHolePixels(silhouette.covered)) / area;
  figures.torn_share = static_cast<double>(CountTornPixels(silhouette.covered)) / area;
  figures.crumb_share = static_cast<double>(CountCrumbs(silhouette)) / area;
  figures.rim = static_cast<double>(CountRim(silhouette.covered)) / std::sqrt(area);
  return figures;
}

}  // namespace

SilhouetteFigures MeasureSilhouettes(const MeshTracer& tracer, const TriangleMesh& mesh,
                                     const std::vector<View>& views, const RunContext& context,
                                     double reduction) {
  std::vector<SilhouetteFigures> of_view(views.size());
  ParallelFor(context, views.size(), 1,
              [&](size_t v) { of_view[v] = Measure(Look(tracer, mesh, views[v], reduction)); });
  SilhouetteFigures mean;
  for (const SilhouetteFigures& figures : of_view) mean.num_views += figures.num_views;
  const double count = static_cast<double>(std::max<size_t>(1, mean.num_views));
  for (const SilhouetteFigures& figures : of_view) {
    mean.coverage += figures.coverage / count;
    mean.hole_share += figures.hole_share / count;
    mean.torn_share += figures.torn_share / count;
    mean.crumb_share += figures.crumb_share / count;
    mean.rim += figures.rim / count;
  }
  return mean;
}

}  // namespace lsmvs
