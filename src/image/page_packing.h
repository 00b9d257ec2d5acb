#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

struct PagePacking {
  std::vector<Eigen::Vector2i> corners;  // left and top of each rectangle that fits
  std::vector<uint8_t> fits;             // 1: it is on the page
  bool all_fit = false;
};

// Places rectangles of these sizes (pixels) without overlap on a square page. Those that find no
// room are left out. A skyline (stb_rect_pack), in an order that depends on the sizes alone: the
// same rectangles give the same places on every machine.
PagePacking PackPage(std::span<const Eigen::Vector2i> sizes, int side);

}  // namespace lsmvs
