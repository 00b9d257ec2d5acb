#include "lsmvs/exporting/tiles/rectangle_packing.h"

#include <gtest/gtest.h>

#include "lsmvs/image/raster.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

std::vector<Eigen::Vector2i> RandomSizes(int count, int largest) {
  Random random(3);
  std::vector<Eigen::Vector2i> sizes;
  for (int i = 0; i < count; ++i) {
    sizes.emplace_back(1 + static_cast<int>(random.Below(static_cast<uint64_t>(largest))),
                       1 + static_cast<int>(random.Below(static_cast<uint64_t>(largest))));
  }
  return sizes;
}

TEST(RectanglePacking, NothingOverlapsAndLittleIsWasted) {
  const auto sizes = RandomSizes(500, 60);
  const PackedRectangles packed = PackRectangles(sizes);
  EXPECT_EQ(packed.page_size.x() % 8, 0);
  EXPECT_EQ(packed.page_size.y() % 8, 0);
  ByteImage used(packed.page_size.x(), packed.page_size.y(), 0);
  double area = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    area += sizes[i].x() * sizes[i].y();
    for (int y = 0; y < sizes[i].y(); ++y) {
      for (int x = 0; x < sizes[i].x(); ++x) {
        ASSERT_TRUE(used.Inside(packed.corners[i].x() + x, packed.corners[i].y() + y));
        EXPECT_EQ(used(packed.corners[i].x() + x, packed.corners[i].y() + y)++, 0);
      }
    }
  }
  EXPECT_GT(area / static_cast<double>(used.size()), 0.8);
}

TEST(RectanglePacking, ExtremesWork) {
  EXPECT_EQ(PackRectangles({}).page_size, Eigen::Vector2i(8, 8));
  EXPECT_EQ(PackRectangles({{1, 1}}).page_size, Eigen::Vector2i(8, 8));
  EXPECT_EQ(PackRectangles({{3000, 2}, {2, 3000}}).corners.size(), 2u);
  EXPECT_THROW(PackRectangles({{20000, 2}}), UsageError);
}

TEST(RectanglePacking, SameSizesGiveSamePlaces) {
  const auto sizes = RandomSizes(300, 4);  // many alike
  EXPECT_EQ(PackRectangles(sizes).corners, PackRectangles(sizes).corners);
}

}  // namespace
}  // namespace lsmvs
