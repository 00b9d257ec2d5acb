#include "lsmvs/scene/cloud_overlap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lsmvs {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

// The square [x, x + 1] x [0, 1] at height 0, 200 points along each side.
std::vector<Eigen::Vector3f> Square(float x) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 200; ++i) {
    for (int j = 0; j < 200; ++j) {
      points.emplace_back(x + (static_cast<float>(i) + 0.5f) / 200,
                          (static_cast<float>(j) + 0.5f) / 200, 0.0f);
    }
  }
  return points;
}

TEST(CloudOverlap, IsTheShareOfPointsWhereOthersAre) {
  EXPECT_THAT(OverlapShares({Square(0), Square(0.75f)}),
              ElementsAre(DoubleNear(0.25, 0.04), DoubleNear(0.25, 0.04)));
  EXPECT_THAT(OverlapShares({Square(0), Square(0)}), ElementsAre(1, 1));
  EXPECT_THAT(OverlapShares({Square(0), Square(3)}), ElementsAre(0, 0));
  EXPECT_THAT(OverlapShares({Square(0), {}}), ElementsAre(0, 0));
  EXPECT_THAT(OverlapShares({}), ElementsAre());
}

TEST(CloudOverlap, AChainOverlapsWithoutWarning) {
  EXPECT_EQ(NoOverlapWarning({"a", "b", "c"}, {Square(0), Square(0.9f), Square(1.8f)}), "");
}

TEST(CloudOverlap, WarnsOfOneThatLiesApart) {
  const std::string warning =
      NoOverlapWarning({"a", "b", "c"}, {Square(0), Square(0.9f), Square(100)});
  EXPECT_THAT(warning, HasSubstr("c: 0.0 % of the points"));
  EXPECT_THAT(warning, HasSubstr("middle (100.5, 0.4975"));
}

TEST(CloudOverlap, SamplesFinitePointsAllOverTheCloud) {
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 100000; ++i) {
    positions.emplace_back(i % 2 == 0 ? static_cast<float>(i) : std::nanf(""), 0.0f, 0.0f);
  }
  const auto sample = SamplePositions(positions);
  EXPECT_GT(sample.size(), 10000u);
  EXPECT_LT(sample.front().x(), 10);
  EXPECT_GT(sample.back().x(), 99900);
  for (const auto& x : sample) EXPECT_TRUE(x.allFinite());
}

}  // namespace
}  // namespace lsmvs
