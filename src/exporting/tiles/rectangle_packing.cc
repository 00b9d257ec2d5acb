#include "lsmvs/exporting/tiles/rectangle_packing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lsmvs/image/page_packing.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr int kGrain = 8, kLargestPage = 16384;

int RoundedUp(double size) { return static_cast<int>(std::ceil(size / kGrain)) * kGrain; }

}  // namespace

PackedRectangles PackRectangles(const std::vector<Eigen::Vector2i>& sizes) {
  double area = 1;
  Eigen::Vector2i largest(1, 1);
  for (const Eigen::Vector2i& size : sizes) {
    area += static_cast<double>(size.x()) * size.y();
    largest = largest.cwiseMax(size);
  }
  double side = std::max(std::sqrt(area), static_cast<double>(largest.maxCoeff()));
  PagePacking page = PackPage(sizes, RoundedUp(side));
  while (!page.all_fit) {
    side = std::max(1.05 * side, side + kGrain);
    page = PackPage(sizes, RoundedUp(side));
  }
  if (RoundedUp(side) > kLargestPage) {
    throw UsageError("a tile would need a texture of more than 16,384 pixels; give smaller tiles");
  }
  PackedRectangles packed;
  Eigen::Vector2i used(1, 1);
  for (size_t i = 0; i < sizes.size(); ++i) {
    used = used.cwiseMax(Eigen::Vector2i(page.corners[i] + sizes[i]));
  }
  packed.corners = std::move(page.corners);
  packed.page_size = {RoundedUp(used.x()), RoundedUp(used.y())};
  return packed;
}

}  // namespace lsmvs
