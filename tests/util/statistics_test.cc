#include "lsmvs/util/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace lsmvs {
namespace {

TEST(StatisticsTest, RanksAreThoseOfTheSortedValues) {
  std::mt19937 random(1);
  for (const size_t count : {1u, 2u, 3u, 10u, 101u}) {
    std::vector<double> values(count);
    for (double& value : values) value = static_cast<double>(random() % 50);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    for (size_t rank = 0; rank < count; ++rank) {
      EXPECT_EQ(ValueOfRank(&values, rank), sorted[rank]);
    }
    EXPECT_EQ(Median(&values), sorted[count / 2]);
    EXPECT_EQ(Quantile(&values, 0), sorted.front());
    EXPECT_EQ(Quantile(&values, 1), sorted.back());
    EXPECT_EQ(Quantile(&values, 0.25), sorted[(count - 1) / 4]);
  }
}

}  // namespace
}  // namespace lsmvs
