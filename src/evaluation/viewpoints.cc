#include "lsmvs/evaluation/viewpoints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace lsmvs {

Eigen::Vector3d UpDirection(const std::vector<View>& views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const View& view : views) sum -= view.cam_from_world.rotation.row(1);
  return sum.norm() > 1e-3 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d(0, -1, 0);
}

std::vector<int> ViewsByName(const std::vector<View>& views) {
  std::vector<int> order(views.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return views[static_cast<size_t>(a)].name < views[static_cast<size_t>(b)].name;
  });
  return order;
}

int MostRevealingView(const Scene& scene) {
  if (scene.views.empty()) return -1;
  std::vector<int> counts(scene.views.size(), 0);
  for (const SparsePoint& point : scene.points) {
    for (const int view : point.view_idxs) ++counts[view];
  }
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

PosedCamera ViewpointOf(const View& view, int width) {
  const double scale = static_cast<double>(width) / view.camera.width;
  const int height = std::max(1, static_cast<int>(std::lround(view.camera.height * scale)));
  return {view.camera.Resized(width, height), view.cam_from_world};
}

std::vector<Eigen::Vector3d> CentralVertices(const TriangleMesh& mesh, const Scene& scene) {
  if (scene.points.empty()) return mesh.vertices;
  Eigen::AlignedBox3d box;
  std::vector<double> values(scene.points.size());
  const size_t cut = values.size() / 25;
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < values.size(); ++i) values[i] = scene.points[i].x_in_world[axis];
    std::sort(values.begin(), values.end());
    const double margin = 0.125 * (values[values.size() - 1 - cut] - values[cut]);
    box.min()[axis] = values[cut] - margin;
    box.max()[axis] = values[values.size() - 1 - cut] + margin;
  }
  std::vector<Eigen::Vector3d> central;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    if (box.contains(x)) central.push_back(x);
  }
  return central.size() > mesh.vertices.size() / 20 ? central : mesh.vertices;
}

TurntableOptions TurntableBefore(const std::vector<Eigen::Vector3d>& points,
                                 const std::vector<View>& views) {
  TurntableOptions options;
  options.up = UpDirection(views);
  options.fit_share = 0.98;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), cameras = Eigen::Vector3d::Zero();
  size_t count = 0;
  for (const Eigen::Vector3d& x : points) {
    if (!x.allFinite()) continue;
    middle += x;
    ++count;
  }
  for (const View& view : views) cameras += view.CenterInWorld();
  if (count == 0 || views.empty()) return options;
  options.front = cameras / static_cast<double>(views.size()) - middle / static_cast<double>(count);
  return options;
}

}  // namespace lsmvs
