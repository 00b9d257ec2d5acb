#include "lsmvs/mesh/spatial_order.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace lsmvs {

namespace {

constexpr int kBits = 10;

// The bits of the number with two zeros between each two.
uint32_t Spread(uint32_t x) {
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  return (x | (x << 2)) & 0x09249249u;
}

uint32_t KeyOf(const Eigen::Vector3d& x_in_cube) {
  constexpr double kCells = 1 << kBits;
  const Eigen::Vector3d cell = (kCells * x_in_cube).cwiseMax(0.0).cwiseMin(kCells - 1);
  return Spread(static_cast<uint32_t>(cell.x())) | Spread(static_cast<uint32_t>(cell.y())) << 1 |
         Spread(static_cast<uint32_t>(cell.z())) << 2;
}

}  // namespace

std::vector<uint32_t> SpatialOrder(std::span<const Eigen::Vector3d> points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : points) box.extend(x);
  const double side = points.empty() ? 0.0 : box.sizes().maxCoeff();
  const double scale = side > 0 ? 1 / side : 0.0;
  std::vector<uint32_t> keys(points.size());
  for (size_t i = 0; i < points.size(); ++i) keys[i] = KeyOf(scale * (points[i] - box.min()));
  std::vector<uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  return order;
}

}  // namespace lsmvs
