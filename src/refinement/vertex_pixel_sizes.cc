#include "lsmvs/refinement/vertex_pixel_sizes.h"

#include <algorithm>
#include <array>
#include <limits>

namespace lsmvs {

namespace {

constexpr size_t kVerticesPerBlock = 4096;
constexpr double kUnseen = std::numeric_limits<double>::infinity();

double PixelSize(const Eigen::Vector3d& x_in_world, const Eigen::Vector3f& normal,
                 const std::vector<PosedCamera>& views) {
  // Best of the views that face the vertex, that have it in the picture, that it lies before.
  std::array<double, 3> sizes = {kUnseen, kUnseen, kUnseen};
  for (const PosedCamera& view : views) {
    const Eigen::Vector3d x = view.cam_from_world * x_in_world;
    if (!(x.z() > 0)) continue;
    const double size = x.z() / view.camera.MeanFocalLength();
    sizes[2] = std::min(sizes[2], size);
    if (!view.camera.Contains(view.camera.Project(x))) continue;
    sizes[1] = std::min(sizes[1], size);
    if (x.dot(view.cam_from_world.rotation * normal.cast<double>()) < 0) {
      sizes[0] = std::min(sizes[0], size);
    }
  }
  const auto best = std::find_if(sizes.begin(), sizes.end(), [](double s) { return s < kUnseen; });
  return best == sizes.end() ? kUnseen : *best;
}

}  // namespace

std::vector<double> VertexPixelSizes(const TriangleMesh& mesh,
                                     const std::vector<PosedCamera>& views,
                                     const RunContext& context) {
  const std::vector<Eigen::Vector3f> normals = ComputeVertexNormals(mesh);
  std::vector<double> sizes(mesh.vertices.size());
  ParallelFor(context, sizes.size(), kVerticesPerBlock,
              [&](size_t v) { sizes[v] = PixelSize(mesh.vertices[v], normals[v], views); });
  if (sizes.empty()) return sizes;
  double smallest = *std::min_element(sizes.begin(), sizes.end());
  if (smallest == kUnseen) smallest = 0;
  std::replace(sizes.begin(), sizes.end(), kUnseen, smallest);
  return sizes;
}

}  // namespace lsmvs
