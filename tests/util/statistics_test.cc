#include "lsmvs/util/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
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

TEST(StatisticsTest, MedianOfValuesThatAreNotHeld) {
  std::mt19937 random(3);
  for (const size_t count : {1, 2, 3, 10, 1001, 5000}) {
    std::vector<double> values(count);
    // Many are alike, others differ in the last bits.
    for (double& value : values) {
      value = std::exp(static_cast<double>(random() % 5)) *
              (1 + 1e-15 * static_cast<double>(random() % 7));
    }
    const auto for_all = [&](const std::function<void(double)>& visit) {
      for (const double value : values) visit(value);
    };
    std::vector<double> held = values;
    EXPECT_EQ(MedianOfPositive(for_all), Median(&held));
  }
  EXPECT_EQ(MedianOfPositive([](const std::function<void(double)>&) {}), std::nullopt);
}

}  // namespace
}  // namespace lsmvs
