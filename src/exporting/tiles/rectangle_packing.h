#pragma once

#include <Eigen/Core>
#include <vector>

namespace lsmvs {

struct PackedRectangles {
  Eigen::Vector2i page_size = Eigen::Vector2i::Zero();  // [px]; multiples of 8
  std::vector<Eigen::Vector2i> corners;                 // left and top of each rectangle
};

// Places rectangles without overlap on a page that is about square and hardly larger than needed.
// The same rectangles give the same places. Skyline packing (stb_rect_pack). Throws UsageError if
// the page would be more than 16,384 pixels wide.
PackedRectangles PackRectangles(const std::vector<Eigen::Vector2i>& sizes);

}  // namespace lsmvs
