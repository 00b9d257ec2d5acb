#include "lsmvs/exporting/tiles/rectangle_packing.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/util/error.h"

namespace {

// stb sorts rectangles of the same size as it likes; ours keep their order on every machine.
template <class Item, class Compare>
void SortStably(Item* items, size_t count, Compare compare) {
  std::stable_sort(items, items + count,
                   [&](const Item& a, const Item& b) { return compare(&a, &b) < 0; });
}

}  // namespace

#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#define STBRP_SORT(items, count, size, compare) \
  SortStably(items, static_cast<size_t>(count), compare)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_rect_pack.h>
#pragma GCC diagnostic pop

namespace lsmvs {

namespace {

constexpr int kGrain = 8, kLargestPage = 16384;

int RoundedUp(double size) { return static_cast<int>(std::ceil(size / kGrain)) * kGrain; }

bool PackInto(int side, std::vector<stbrp_rect>* rectangles) {
  std::vector<stbrp_node> nodes(static_cast<size_t>(side));
  stbrp_context context;
  stbrp_init_target(&context, side, side, nodes.data(), side);
  return stbrp_pack_rects(&context, rectangles->data(), static_cast<int>(rectangles->size())) != 0;
}

}  // namespace

PackedRectangles PackRectangles(const std::vector<Eigen::Vector2i>& sizes) {
  double area = 1;
  Eigen::Vector2i largest(1, 1);
  std::vector<stbrp_rect> rectangles(sizes.size());
  for (size_t i = 0; i < sizes.size(); ++i) {
    rectangles[i] = {static_cast<int>(i), sizes[i].x(), sizes[i].y(), 0, 0, 0};
    area += static_cast<double>(sizes[i].x()) * sizes[i].y();
    largest = largest.cwiseMax(sizes[i]);
  }
  double side = std::max(std::sqrt(area), static_cast<double>(largest.maxCoeff()));
  while (!PackInto(RoundedUp(side), &rectangles)) side = std::max(1.05 * side, side + kGrain);
  if (RoundedUp(side) > kLargestPage) {
    throw UsageError("a tile would need a texture of more than 16,384 pixels; give smaller tiles");
  }
  PackedRectangles packed;
  packed.corners.resize(sizes.size());
  Eigen::Vector2i used(1, 1);
  for (const stbrp_rect& r : rectangles) {
    packed.corners[static_cast<size_t>(r.id)] = {r.x, r.y};
    used = used.cwiseMax(Eigen::Vector2i(r.x + r.w, r.y + r.h));
  }
  packed.page_size = {RoundedUp(used.x()), RoundedUp(used.y())};
  return packed;
}

}  // namespace lsmvs
