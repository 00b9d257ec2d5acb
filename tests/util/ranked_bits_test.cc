#include "lsmvs/util/ranked_bits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace lsmvs {
namespace {

TEST(RankedBits, CountsTheMembersBefore) {
  const std::set<size_t> members = {0, 1, 5, 63, 64, 65, 127, 128, 190, 199};
  RankedBits bits;
  bits.Assign(200);
  for (const size_t element : members) bits.Set(element);
  bits.Rank();
  int32_t before = 0;
  for (size_t element = 0; element < 200; ++element) {
    EXPECT_EQ(bits.RankOf(element), members.contains(element) ? before++ : -1) << element;
  }
}

TEST(RankedBits, VisitsAscendingAndMayClearOnTheWay) {
  RankedBits bits;
  bits.Assign(130);
  for (const size_t element : {129u, 3u, 64u, 4u}) bits.Set(element);
  std::vector<size_t> visited;
  bits.ForEach([&](size_t element) {
    visited.push_back(element);
    if (element == 4) bits.Clear(element);
  });
  EXPECT_THAT(visited, testing::ElementsAre(3, 4, 64, 129));
  bits.Rank();
  EXPECT_EQ(bits.RankOf(4), -1);
  EXPECT_EQ(bits.RankOf(129), 2);
}

TEST(RankedBits, AssignForgets) {
  RankedBits bits;
  bits.Assign(70);
  bits.Set(69);
  bits.Assign(70);
  bits.Rank();
  EXPECT_EQ(bits.RankOf(69), -1);
}

}  // namespace
}  // namespace lsmvs
