#include "lsmvs/scene/scene.h"

#include <algorithm>
#include <filesystem>
#include <functional>

#include "lsmvs/scene/points_by_view.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

DepthRange QuantileRange(std::vector<double>* depths, double margin) {
  if (depths->empty()) return {};
  std::sort(depths->begin(), depths->end());
  const auto at = [&](double q) {
    return (*depths)[static_cast<size_t>(q * static_cast<double>(depths->size() - 1))];
  };
  return {at(0.01) / (1 + margin), at(0.99) * (1 + margin)};
}

// Of all points before the view.
std::vector<double> PositiveDepths(const Scene& scene, const View& view) {
  std::vector<double> depths;
  for (const SparsePoint& point : scene.points) {
    const double depth = view.Depth(point.x_in_world);
    if (depth > 0) depths.push_back(depth);
  }
  return depths;
}

}  // namespace

std::vector<uint32_t> PointsInImage(const Scene& scene, int view_idx) {
  const View& view = scene.views[static_cast<size_t>(view_idx)];
  std::vector<uint32_t> point_idxs;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    const Eigen::Vector3d x = view.cam_from_world * scene.points[p].x_in_world;
    if (x.z() > 0 && view.camera.Contains(view.camera.Project(x))) {
      point_idxs.push_back(static_cast<uint32_t>(p));
    }
  }
  return point_idxs;
}

std::vector<DepthRange> EstimateDepthRanges(const Scene& scene, double margin) {
  const PointsByView points(scene);
  std::vector<DepthRange> ranges(scene.views.size());
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    std::vector<double> depths;
    for (const uint32_t p : points.Of(static_cast<int>(v))) {
      const double depth = view.Depth(scene.points[p].x_in_world);
      if (depth > 0) depths.push_back(depth);
    }
    if (depths.size() < kMinPointsOfView) {
      depths.clear();
      for (const uint32_t p : PointsInImage(scene, static_cast<int>(v))) {
        depths.push_back(view.Depth(scene.points[p].x_in_world));
      }
    }
    if (depths.size() < kMinPointsOfView) depths = PositiveDepths(scene, view);
    ranges[v] = QuantileRange(&depths, margin);
  }
  return ranges;
}

double MeanTrackLength(const Scene& scene) {
  constexpr double kUsual = 4;
  size_t num_points = 0, num_views = 0;
  for (const SparsePoint& point : scene.points) {
    if (point.view_idxs.size() < 2) continue;
    ++num_points;
    num_views += point.view_idxs.size();
  }
  return num_points == 0 ? kUsual
                         : static_cast<double>(num_views) / static_cast<double>(num_points);
}

double GroundSamplingDistance(const Scene& scene) {
  const auto for_all_distances = [&](const std::function<void(double)>& visit) {
    for (const SparsePoint& point : scene.points) {
      for (const int view_idx : point.view_idxs) {
        const View& view = scene.views[view_idx];
        const double depth = view.Depth(point.x_in_world);
        if (depth > 0) visit(depth / view.camera.MeanFocalLength());
      }
    }
  };
  return MedianOfPositive(for_all_distances).value_or(0.0);
}

std::string MaskPath(const std::string& mask_folder, const std::string& image_name) {
  if (mask_folder.empty()) return "";
  const std::filesystem::path path = std::filesystem::path(mask_folder) / image_name;
  std::filesystem::path of_stem = path;
  of_stem.replace_extension(".png");
  for (const auto& mask : {std::filesystem::path(path.string() + ".png"), of_stem}) {
    if (std::filesystem::exists(mask)) return mask.string();
  }
  return "";
}

std::unique_ptr<ImageStore> MakeImageStore(const Scene& scene, const ImageStoreOptions& options) {
  std::vector<ImageSource> sources;
  for (const View& view : scene.views) {
    ImageSource source{(std::filesystem::path(scene.image_folder) / view.name).string(),
                       MaskPath(scene.mask_folder, view.name), view.camera};
    source.is_missing = !view.has_photo;
    source.alpha_is_mask = scene.alpha_is_mask && view.has_photo &&
                           std::filesystem::is_regular_file(source.path) && HasAlpha(source.path);
    sources.push_back(std::move(source));
  }
  return std::make_unique<ImageStore>(std::move(sources), options);
}

}  // namespace lsmvs
