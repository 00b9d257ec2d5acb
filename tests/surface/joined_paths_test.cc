#include "lsmvs/surface/weights/joined_paths.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace lsmvs::internal {
namespace {

using Weights = std::map<std::pair<int32_t, int>, int32_t>;  // (cell, facet) -> weight

struct Carried {
  Weights facets;
  std::vector<int32_t> ends;
};

Carried Carry(JoinedPaths* paths) {
  Carried carried;
  paths->Carry(
      [&](int32_t cell, int facet, int32_t weight) {
        int32_t& sum = carried.facets[{cell, facet}];
        sum = AddCapacities(sum, weight);
      },
      [&](int32_t cell) { carried.ends.push_back(cell); });
  return carried;
}

// True if the path joined another.
bool Walk(JoinedPaths* paths, int32_t weight, const std::vector<std::pair<int32_t, int>>& way) {
  paths->Begin(weight);
  for (const auto& [cell, facet] : way) {
    if (!paths->Enter(cell, facet)) return true;
  }
  return false;
}

TEST(JoinedPaths, OnePathWeighsOnEveryFacet) {
  JoinedPaths paths(10);
  EXPECT_FALSE(Walk(&paths, 7, {{3, 0}, {5, 2}, {8, 1}}));
  const Carried carried = Carry(&paths);
  EXPECT_EQ(carried.facets, (Weights{{{3, 0}, 7}, {{5, 2}, 7}, {{8, 1}, 7}}));
  EXPECT_EQ(carried.ends, std::vector<int32_t>{8});
}

TEST(JoinedPaths, TwoCellsInARowJoin) {
  JoinedPaths paths(10);
  Walk(&paths, 7, {{3, 0}, {5, 2}, {8, 1}, {9, 0}});
  EXPECT_TRUE(Walk(&paths, 4, {{2, 3}, {5, 1}, {8, 1}, {7, 0}}));
  const Carried carried = Carry(&paths);
  // The second way's own facets, and from cell 8 on the first one's.
  EXPECT_EQ(
      carried.facets,
      (Weights{{{3, 0}, 7}, {{5, 2}, 7}, {{2, 3}, 4}, {{5, 1}, 4}, {{8, 1}, 11}, {{9, 0}, 11}}));
  EXPECT_EQ(carried.ends, std::vector<int32_t>{9});
}

TEST(JoinedPaths, CrossingOneCellDoesNotJoin) {
  JoinedPaths paths(10);
  Walk(&paths, 7, {{3, 0}, {5, 2}, {8, 1}});
  EXPECT_FALSE(Walk(&paths, 4, {{2, 3}, {5, 1}, {7, 1}}));
  const Carried carried = Carry(&paths);
  EXPECT_EQ(
      carried.facets,
      (Weights{{{3, 0}, 7}, {{5, 2}, 7}, {{8, 1}, 7}, {{2, 3}, 4}, {{5, 1}, 4}, {{7, 1}, 4}}));
  EXPECT_EQ(carried.ends, (std::vector<int32_t>{7, 8}));
}

// Whatever joins where, as much arrives as set off.
TEST(JoinedPaths, WhatSetsOffArrives) {
  constexpr int kRows = 50, kColumns = 20;
  JoinedPaths paths(kRows * kColumns + 1);
  int32_t total = 0;
  for (int i = 0; i < 500; ++i) {
    paths.Begin(1 + i % 9);
    total += 1 + i % 9;
    bool alone = true;
    for (int row = 0; row < kRows && alone; ++row) {
      const int column = (i * (kRows - row)) / kRows % kColumns;
      alone = paths.Enter(row * kColumns + column, 0);
    }
    if (alone) paths.Enter(kRows * kColumns, i % 4);
  }
  const Carried carried = Carry(&paths);
  int32_t first_row = 0, end = 0;
  for (const auto& [facet, weight] : carried.facets) {
    if (facet.first < kColumns) first_row += weight;
    if (facet.first == kRows * kColumns) end += weight;
  }
  EXPECT_EQ(first_row, total);
  EXPECT_EQ(end, total);
}

TEST(JoinedPaths, CarryForgets) {
  JoinedPaths paths(10);
  Walk(&paths, 7, {{3, 0}, {5, 2}});
  Carry(&paths);
  EXPECT_FALSE(Walk(&paths, 2, {{3, 0}, {5, 2}}));
  EXPECT_EQ(Carry(&paths).facets, (Weights{{{3, 0}, 2}, {{5, 2}, 2}}));
}

TEST(JoinedPaths, SumsSaturate) {
  JoinedPaths paths(10);
  for (int i = 0; i < 4; ++i) Walk(&paths, CutNode::kMaxCapacity, {{3, 0}, {5, 2}, {6, 1}});
  EXPECT_EQ((Carry(&paths).facets[{6, 1}]), CutNode::kMaxCapacity);
}

}  // namespace
}  // namespace lsmvs::internal
