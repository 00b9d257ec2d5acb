#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

struct Packing {
  int page_side = 0;  // texels; all pages are squares of this size
  int num_pages = 0;
  std::vector<uint16_t> page_idx;         // of each rectangle
  std::vector<Eigen::Vector2i> position;  // its upper left texel
};

// Lays rectangles on as few square pages of at most `max_side` as it can, then makes the pages as
// small as this number of them allows. Rectangles that follow each other in `order` come on the
// same page where there is a choice. No rectangle may be larger than `max_side`. A skyline
// (stb_rect_pack) in an order that depends on the sizes alone. Throws std::logic_error for a
// rectangle that is too large, and MemoryError beyond 65,535 pages.
Packing PackRectangles(std::span<const Eigen::Vector2i> sizes, std::span<const uint32_t> order,
                       int max_side);

}  // namespace lsmvs
