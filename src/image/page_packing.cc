#include "lsmvs/image/page_packing.h"

#include <algorithm>

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

PagePacking Pack(std::span<const Eigen::Vector2i> sizes, int side, int heuristic) {
  std::vector<stbrp_rect> rects(sizes.size());
  for (size_t i = 0; i < sizes.size(); ++i) {
    rects[i] = {static_cast<int>(i), sizes[i].x(), sizes[i].y(), 0, 0, 0};
  }
  std::vector<stbrp_node> nodes(static_cast<size_t>(side));
  stbrp_context context;
  stbrp_init_target(&context, side, side, nodes.data(), side);
  stbrp_setup_heuristic(&context, heuristic);
  PagePacking packing;
  packing.all_fit = stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size())) != 0;
  for (const stbrp_rect& rect : rects) {
    packing.corners.emplace_back(rect.x, rect.y);
    packing.fits.push_back(rect.was_packed != 0);
  }
  return packing;
}

int64_t PackedArea(std::span<const Eigen::Vector2i> sizes, const PagePacking& packing) {
  int64_t area = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    if (packing.fits[i] != 0) area += int64_t{sizes[i].x()} * sizes[i].y();
  }
  return area;
}

}  // namespace

// Neither heuristic is better on all inputs.
PagePacking PackPage(std::span<const Eigen::Vector2i> sizes, int side) {
  PagePacking best_fit = Pack(sizes, side, STBRP_HEURISTIC_Skyline_BF_sortHeight);
  if (best_fit.all_fit) return best_fit;
  PagePacking bottom_left = Pack(sizes, side, STBRP_HEURISTIC_Skyline_BL_sortHeight);
  const bool is_better =
      bottom_left.all_fit || PackedArea(sizes, bottom_left) > PackedArea(sizes, best_fit);
  return is_better ? bottom_left : best_fit;
}

}  // namespace lsmvs
