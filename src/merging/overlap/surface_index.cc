#include "lsmvs/merging/overlap/surface_index.h"

#include <bit>

#include "lsmvs/geometry/hilbert_order.h"

namespace lsmvs {

std::vector<Eigen::Vector3i> PointFaces(size_t count) {
  std::vector<Eigen::Vector3i> faces;
  for (size_t i = 0; i < count; ++i)
    faces.push_back(Eigen::Vector3i::Constant(static_cast<int>(i)));
  return faces;
}

SurfaceIndex::SurfaceIndex(std::span<const Eigen::Vector3d> vertices,
                           std::span<const Eigen::Vector3i> faces)
    : vertices_(vertices), faces_(faces) {
  if (faces.empty()) return;
  const Eigen::Vector3d origin = vertices[static_cast<size_t>(faces[0][0])];
  std::vector<Eigen::Vector3f> middles;
  middles.reserve(faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    const Triangle3 t = TriangleOf(static_cast<int32_t>(f));
    middles.push_back(((t.a + t.b + t.c) / 3 - origin).cast<float>());
  }
  order_ = HilbertOrder(middles);
  num_leaves_ = std::bit_ceil((order_.size() + kLeafSize - 1) / kLeafSize);
  boxes_.resize(2 * num_leaves_);
  for (size_t i = 0; i < order_.size(); ++i) {
    const Triangle3 t = TriangleOf(static_cast<int32_t>(order_[i]));
    boxes_[num_leaves_ + i / kLeafSize].extend(t.a).extend(t.b).extend(t.c);
  }
  for (size_t node = num_leaves_ - 1; node > 0; --node) {
    boxes_[node] = boxes_[2 * node].merged(boxes_[2 * node + 1]);
  }
}

}  // namespace lsmvs
