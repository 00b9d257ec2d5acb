#include "lsmvs/surface/points/point_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <vector>

namespace lsmvs {

namespace {

std::array<uint32_t, 3> BitsOf(const Eigen::Vector3f& x) {
  return {std::bit_cast<uint32_t>(x[0]), std::bit_cast<uint32_t>(x[1]),
          std::bit_cast<uint32_t>(x[2])};
}

std::array<uint8_t, 3> BytesOf(const Color& color) { return {color[0], color[1], color[2]}; }

// A coordinate in an image as an integer of kCoordinateBits; outside of the image the border's.
constexpr int kCoordinateBits = 22;
uint64_t InSteps(double x, int size) {
  constexpr double kLast = (1 << kCoordinateBits) - 1;
  const double step = x / size * (kLast + 1);
  return step > 0 ? static_cast<uint64_t>(std::min(step, kLast)) : 0;  // also if it is NaN
}

}  // namespace

FinestView FindFinestView(const Scene& scene, const VisibilityCloud& cloud, size_t point) {
  FinestView finest;
  if (!cloud.positions[point].allFinite()) return finest;
  finest.pixel_size = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d x = cloud.positions[point].cast<double>();
  for (const uint32_t view_idx : cloud.ViewsOf(point)) {
    const View& view = scene.views[view_idx];
    const double depth = view.Depth(x);
    const double pixel_size = depth / view.camera.MeanFocalLength();
    if (depth > 0 && pixel_size < finest.pixel_size) finest = {view_idx, depth, pixel_size};
  }
  return finest;
}

bool PointOrder::Less(uint32_t a, uint32_t b) const {
  const auto position_a = BitsOf(cloud_.positions[a]), position_b = BitsOf(cloud_.positions[b]);
  if (position_a != position_b) return position_a < position_b;
  const auto normal_a = BitsOf(cloud_.normals[a]), normal_b = BitsOf(cloud_.normals[b]);
  if (normal_a != normal_b) return normal_a < normal_b;
  const auto color_a = BytesOf(cloud_.colors[a]), color_b = BytesOf(cloud_.colors[b]);
  if (color_a != color_b) return color_a < color_b;
  const auto views_a = cloud_.ViewsOf(a), views_b = cloud_.ViewsOf(b);
  return std::ranges::lexicographical_compare(views_a, views_b);
}

uint64_t PointOrder::KeyAlongViews(uint32_t point) const {
  // 32 x 32 tiles an image, of 16 x 16 cells.
  constexpr int kTileBits = 5, kCellBits = 4, kInCellBits = kCoordinateBits - kTileBits - kCellBits;
  constexpr auto bits = [](uint64_t value, int lowest, int count) {
    return (value >> lowest) & ((uint64_t{1} << count) - 1);
  };
  const FinestView finest = FindFinestView(scene_, cloud_, point);
  const View& view = scene_.views[finest.view_idx];
  const Eigen::Vector2d x_px =
      view.camera.Project(view.cam_from_world * cloud_.positions[point].cast<double>());
  const uint64_t x = InSteps(x_px.x(), view.camera.width);
  const uint64_t y = InSteps(x_px.y(), view.camera.height);
  uint64_t key = finest.view_idx;  // its upper bits may fall off: then the tiles of some views mix
  key = key << kTileBits | bits(y, kCoordinateBits - kTileBits, kTileBits);
  key = key << kTileBits | bits(x, kCoordinateBits - kTileBits, kTileBits);
  // Cells far apart first: their lowest bits come first.
  for (int bit = kInCellBits; bit < kInCellBits + kCellBits; ++bit) {
    key = key << 2 | bits(x ^ y, bit, 1) << 1 | bits(y, bit, 1);
  }
  key = key << kInCellBits | bits(y, 0, kInCellBits);
  return key << kInCellBits | bits(x, 0, kInCellBits);
}

void PointOrder::SortAlongViews(const RunContext& context, std::span<uint32_t> points) const {
  struct Item {
    uint64_t key;
    uint32_t point;
  };
  constexpr size_t kBlock = 1 << 14;
  std::vector<Item> items(points.size());
  ParallelFor(context, items.size(), kBlock, [&](size_t i) {
    items[i] = {KeyAlongViews(points[i]), points[i]};
  });
  std::sort(items.begin(), items.end(), [&](const Item& a, const Item& b) {
    return a.key != b.key ? a.key < b.key : Less(a.point, b.point);
  });
  for (size_t i = 0; i < items.size(); ++i) points[i] = items[i].point;
}

uint64_t HashOfPosition(const Eigen::Vector3f& x) {
  uint64_t hash = 0;
  for (const uint32_t bits : BitsOf(x)) {
    hash = (hash ^ bits) * 0x9E3779B97F4A7C15ull;
    hash ^= hash >> 32;
  }
  return hash * 0x9E3779B97F4A7C15ull;
}

}  // namespace lsmvs
