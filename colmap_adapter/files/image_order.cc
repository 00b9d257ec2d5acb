#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "lsmvs/colmap_adapter/files/image_order.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"

namespace lsmvs::internal {

namespace {

constexpr size_t kSamplePoints = 2000;
// A point on the border of an image may fall just outside after rounding.
constexpr double kBorder_px = 2.0;

bool IsInside(const View& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d x_in_cam = view.cam_from_world * x_in_world;
  if (!(x_in_cam.z() > 0)) return false;
  const Eigen::Vector2d x = view.camera.Project(x_in_cam);
  return x.x() > -kBorder_px && x.y() > -kBorder_px && x.x() < view.camera.width + kBorder_px &&
         x.y() < view.camera.height + kBorder_px;
}

template <class Less>
ImageOrder SortedOrder(const Scene& scene, const char* name, const Less& less) {
  ImageOrder order = SceneOrder(scene);
  order.name = name;
  std::sort(order.view_idxs.begin(), order.view_idxs.end(),
            [&](uint32_t a, uint32_t b) { return less(scene.views[a], scene.views[b]); });
  return order;
}

ImageOrder FileOrder(const Scene& scene, const std::filesystem::path& sparse_folder) {
  std::unordered_map<std::string, uint32_t> view_of_name;
  for (uint32_t v = 0; v < scene.views.size(); ++v) view_of_name[scene.views[v].name] = v;
  ImageOrder order{"the order of the sparse model's images file", {}};
  const SparseModel model =
      ReadSparseModel(sparse_folder, {.keep_points2d = false, .keep_points3d = false});
  for (const SparseModel::Image& image : model.images) {
    const auto view = view_of_name.find(image.name);
    if (view != view_of_name.end()) order.view_idxs.push_back(view->second);
  }
  return order;
}

}  // namespace

ImageOrder SceneOrder(const Scene& scene) {
  ImageOrder order{"the order of registered images", {}};
  order.view_idxs.resize(scene.views.size());
  std::iota(order.view_idxs.begin(), order.view_idxs.end(), 0u);
  return order;
}

std::vector<ImageOrder> OtherOrders(const Scene& scene,
                                    const std::filesystem::path& sparse_folder) {
  std::vector<ImageOrder> orders;
  const ImageOrder expected = SceneOrder(scene);
  const auto add = [&](ImageOrder order) {
    const bool is_complete = order.view_idxs.size() == scene.views.size();
    if (is_complete && order.view_idxs != expected.view_idxs) orders.push_back(std::move(order));
  };
  add(FileOrder(scene, sparse_folder));
  add(SortedOrder(scene, "the order of image ids",
                  [](const View& a, const View& b) { return a.image_id < b.image_id; }));
  add(SortedOrder(scene, "the order of image names",
                  [](const View& a, const View& b) { return a.name < b.name; }));
  return orders;
}

OrderFit MeasureFit(const Scene& scene, const VisibilityCloud& points, const VisibilityFile& file,
                    size_t first_point, const ImageOrder& order) {
  size_t num_pairs = 0, num_inside = 0, num_with_normal = 0, num_facing = 0;
  const size_t num_points = std::min(points.positions.size(), file.num_points());
  const size_t step = (num_points - first_point) / kSamplePoints + 1;
  for (size_t p = first_point; p < num_points; p += step) {
    const Eigen::Vector3d x = points.positions[p].cast<double>();
    const Eigen::Vector3d normal = points.normals[p].cast<double>();
    if (!x.allFinite()) continue;
    for (uint64_t i = file.begin[p]; i < file.begin[p + 1]; ++i) {
      const View& view = scene.views[order.view_idxs[file.image_idxs[i]]];
      ++num_pairs;
      num_inside += IsInside(view, x);
      if (!(normal.squaredNorm() > 0)) continue;
      ++num_with_normal;
      num_facing += normal.dot(view.CenterInWorld() - x) > 0;
    }
  }
  const auto ratio = [](size_t part, size_t whole) {
    return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  return {ratio(num_inside, num_pairs), ratio(num_facing, num_with_normal)};
}

}  // namespace lsmvs::internal
