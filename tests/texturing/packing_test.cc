#include "lsmvs/texturing/charts/packing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "lsmvs/image/raster.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

std::vector<Eigen::Vector2i> RandomSizes(size_t count, int largest) {
  Random random(1);
  std::vector<Eigen::Vector2i> sizes;
  for (size_t i = 0; i < count; ++i) {
    const auto side = [&] { return static_cast<int>(1 + random.Below(largest)); };
    const int width = side();
    sizes.emplace_back(width, side());
  }
  return sizes;
}

std::vector<uint32_t> InOrder(size_t count) {
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

double ExpectDisjoint(const std::vector<Eigen::Vector2i>& sizes, const Packing& packing) {
  std::vector<Raster<uint8_t>> pages(
      static_cast<size_t>(packing.num_pages),
      Raster<uint8_t>(packing.page_side, packing.page_side, uint8_t{0}));
  double area = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    Raster<uint8_t>& page = pages.at(packing.page_idx[i]);
    for (int y = 0; y < sizes[i].y(); ++y) {
      for (int x = 0; x < sizes[i].x(); ++x) {
        const int column = packing.position[i].x() + x, row = packing.position[i].y() + y;
        if (!page.Inside(column, row) || page(column, row)++ != 0) {
          ADD_FAILURE() << "rectangle " << i;
          return 0;
        }
      }
    }
    area += sizes[i].prod();
  }
  return area / (static_cast<double>(packing.num_pages) * packing.page_side * packing.page_side);
}

TEST(Packing, FillsASmallPageWell) {
  const auto sizes = RandomSizes(500, 40);
  const Packing packing = PackRectangles(sizes, InOrder(sizes.size()), 4096);
  EXPECT_EQ(packing.num_pages, 1);
  EXPECT_GT(ExpectDisjoint(sizes, packing), 0.85);
}

TEST(Packing, TakesMorePagesWhereItMust) {
  const auto sizes = RandomSizes(800, 60);
  const Packing packing = PackRectangles(sizes, InOrder(sizes.size()), 256);
  EXPECT_GT(packing.num_pages, 5);
  EXPECT_LE(packing.page_side, 256);
  EXPECT_GT(ExpectDisjoint(sizes, packing), 0.75);
  // What follows each other mostly comes together.
  const auto begin = packing.page_idx.begin();
  EXPECT_GE(std::count_if(begin, begin + 30, [](uint16_t page) { return page <= 1; }), 27);
}

TEST(Packing, TakesARectangleAsLargeAsThePageAndRefusesLargerOnes) {
  const std::vector<Eigen::Vector2i> one = {{256, 256}};
  EXPECT_EQ(PackRectangles(one, InOrder(1), 256).page_side, 256);
  const std::vector<Eigen::Vector2i> larger = {{257, 3}};
  EXPECT_THROW(PackRectangles(larger, InOrder(1), 256), std::logic_error);
  EXPECT_EQ(PackRectangles({}, {}, 256).num_pages, 0);
}

}  // namespace
}  // namespace lsmvs
