#include "lsmvs/scene/scene.h"

#include <algorithm>
#include <filesystem>

namespace lsmvs {

namespace {

constexpr size_t kMinPointsForOwnRange = 10;

DepthRange QuantileRange(std::vector<double>* depths, double margin) {
  if (depths->empty()) return {};
  std::sort(depths->begin(), depths->end());
  const auto at = [&](double q) {
    return (*depths)[static_cast<size_t>(q * static_cast<double>(depths->size() - 1))];
  };
  return {at(0.01) / (1 + margin), at(0.99) * (1 + margin)};
}

}  // namespace

std::vector<DepthRange> EstimateDepthRanges(const Scene& scene, double margin) {
  std::vector<std::vector<double>> depths(scene.views.size());
  for (const SparsePoint& point : scene.points) {
    for (const int view_idx : point.view_idxs) {
      const double depth = scene.views[view_idx].Depth(point.x_in_world);
      if (depth > 0) depths[view_idx].push_back(depth);
    }
  }
  std::vector<DepthRange> ranges(scene.views.size());
  for (size_t v = 0; v < scene.views.size(); ++v) {
    if (depths[v].size() < kMinPointsForOwnRange) {
      depths[v].clear();
      for (const SparsePoint& point : scene.points) {
        const double depth = scene.views[v].Depth(point.x_in_world);
        if (depth > 0) depths[v].push_back(depth);
      }
    }
    ranges[v] = QuantileRange(&depths[v], margin);
  }
  return ranges;
}

double GroundSamplingDistance(const Scene& scene) {
  std::vector<double> distances;
  for (const SparsePoint& point : scene.points) {
    for (const int view_idx : point.view_idxs) {
      const View& view = scene.views[view_idx];
      const double depth = view.Depth(point.x_in_world);
      if (depth > 0) distances.push_back(depth / view.camera.MeanFocalLength());
    }
  }
  if (distances.empty()) return 0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
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
