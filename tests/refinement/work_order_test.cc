#include "lsmvs/refinement/photo/work_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace lsmvs {
namespace {

// Two groups of views that see nothing of each other, numbered alternately.
std::vector<ViewPair> TwoGroups(int num_views) {
  std::vector<ViewPair> pairs;
  for (int i = 0; i < num_views; ++i) {
    for (int j = i % 2; j < num_views; j += 2) {
      if (j != i && std::abs(i - j) <= 4) pairs.push_back({i, j});
    }
  }
  return pairs;
}

TEST(WorkOrder, HasEachFirstViewOfAPairOnce) {
  std::vector<ViewPair> pairs = TwoGroups(20);
  std::erase_if(pairs, [](const ViewPair& pair) { return pair.i == 7; });
  const std::vector<int> order = WorkOrder(pairs, 25);
  EXPECT_EQ(order.size(), 19u);
  std::set<int> views(order.begin(), order.end());
  EXPECT_EQ(views.size(), 19u);
  EXPECT_FALSE(views.contains(7));
}

TEST(WorkOrder, GoesThroughOneGroupBeforeTheOther) {
  const std::vector<int> order = WorkOrder(TwoGroups(20), 20);
  const auto changes = [&] {
    int count = 0;
    for (size_t k = 1; k < order.size(); ++k) count += order[k] % 2 != order[k - 1] % 2;
    return count;
  };
  EXPECT_EQ(changes(), 1);
}

TEST(WorkOrder, IsEmptyWithoutPairs) { EXPECT_TRUE(WorkOrder({}, 5).empty()); }

}  // namespace
}  // namespace lsmvs
