#include "lsmvs/scene/visibility_cloud.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace lsmvs {
namespace {

VisibilityCloud TwoPoints() {
  VisibilityCloud cloud;
  cloud.Reserve(2, 5);
  cloud.Add({1, 2, 3}, {0, 0, 1}, Color(1, 2, 3), std::vector<uint32_t>{4, 1, 4, 0});
  cloud.Add({4, 5, 6}, {0, 1, 0}, Color(4, 5, 6), std::vector<uint32_t>{});
  cloud.Add({7, 8, 9}, {1, 0, 0}, Color(7, 8, 9), std::vector<uint32_t>{2});
  return cloud;
}

TEST(VisibilityCloud, SortsViewsAndDropsDuplicates) {
  const VisibilityCloud cloud = TwoPoints();
  ASSERT_EQ(cloud.size(), 3u);
  const auto views = cloud.ViewsOf(0);
  EXPECT_EQ(std::vector<uint32_t>(views.begin(), views.end()), (std::vector<uint32_t>{0, 1, 4}));
  EXPECT_TRUE(cloud.ViewsOf(1).empty());
  EXPECT_EQ(cloud.ViewsOf(2)[0], 2u);
  EXPECT_EQ(cloud.positions[2], Eigen::Vector3f(7, 8, 9));
  EXPECT_EQ(cloud.colors[1], Color(4, 5, 6));
}

TEST(VisibilityCloud, KeepsWhatIsWanted) {
  for (unsigned mask = 0; mask < 8; ++mask) {
    VisibilityCloud cloud = TwoPoints(), expected;
    for (size_t p = 0; p < 3; ++p) {
      if ((mask >> p & 1) == 0) continue;
      expected.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], cloud.ViewsOf(p));
    }
    cloud.KeepIf([&](size_t p) { return (mask >> p & 1) != 0; });
    EXPECT_NO_THROW(cloud.CheckConsistent(5));
    EXPECT_EQ(cloud.positions, expected.positions);
    EXPECT_EQ(cloud.normals, expected.normals);
    EXPECT_EQ(cloud.colors, expected.colors);
    EXPECT_EQ(cloud.view_begin, expected.view_begin);
    EXPECT_EQ(cloud.view_idxs, expected.view_idxs);
  }
}

TEST(VisibilityCloud, ChecksItself) {
  EXPECT_NO_THROW(TwoPoints().CheckConsistent(5));
  EXPECT_NO_THROW(VisibilityCloud().CheckConsistent(0));
  EXPECT_THROW(TwoPoints().CheckConsistent(4), std::logic_error);
  VisibilityCloud cloud = TwoPoints();
  cloud.normals.pop_back();
  EXPECT_THROW(cloud.CheckConsistent(5), std::logic_error);
  cloud = TwoPoints();
  cloud.view_begin[1] = 4;
  cloud.view_begin[2] = 3;
  EXPECT_THROW(cloud.CheckConsistent(5), std::logic_error);
  cloud = TwoPoints();
  cloud.view_idxs.push_back(1);
  EXPECT_THROW(cloud.CheckConsistent(5), std::logic_error);
}

}  // namespace
}  // namespace lsmvs
