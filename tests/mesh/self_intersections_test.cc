#include "lsmvs/mesh/self_intersections.h"

#include <gtest/gtest.h>

#include <random>

namespace lsmvs {
namespace {

using Vertices = std::vector<Eigen::Vector3d>;
using Faces = std::vector<Eigen::Vector3i>;

TEST(FaceGrid, FindsWhatAllPairsFind) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(0, 10), offset(-1, 1);
  Vertices vertices;
  Faces faces;
  for (int f = 0; f < 300; ++f) {
    const Eigen::Vector3d center(place(random), place(random), place(random));
    for (int k = 0; k < 3; ++k) {
      vertices.push_back(center + Eigen::Vector3d(offset(random), offset(random), offset(random)));
    }
    faces.emplace_back(3 * f, 3 * f + 1, 3 * f + 2);
  }
  std::vector<std::pair<int32_t, int32_t>> expected;
  for (int a = 0; a < 300; ++a) {
    for (int b = a + 1; b < 300; ++b) {
      if (FacesCross(vertices, faces[static_cast<size_t>(a)], faces[static_cast<size_t>(b)])) {
        expected.emplace_back(a, b);
      }
    }
  }
  ASSERT_GT(expected.size(), 20u);
  const std::vector<uint8_t> all(300, 1), none(300, 0);
  const FaceGrid grid(vertices, faces);
  EXPECT_EQ(grid.CrossingPairs(all, RunContext(2)), expected);
  EXPECT_TRUE(grid.CrossingPairs(none, RunContext(1)).empty());
}

TEST(FacesCross, TouchingIsNotCrossing) {
  const Vertices vertices = {{0, 0, 0},  {4, 0, 0}, {0, 4, 0}, {1, 1, 0}, {1, 1, 3},    {2, 1, 3},
                             {1, 1, -1}, {9, 9, 0}, {9, 8, 0}, {8, 9, 0}, {0.5, 0.5, 0}};
  EXPECT_FALSE(FacesCross(vertices, {0, 1, 2}, {3, 4, 5}));  // a corner lies on it
  EXPECT_TRUE(FacesCross(vertices, {0, 1, 2}, {6, 4, 5}));   // an edge pierces it
  EXPECT_FALSE(FacesCross(vertices, {0, 1, 2}, {7, 8, 9}));  // in one plane, apart
  EXPECT_FALSE(FacesCross(vertices, {0, 1, 2}, {0, 1, 4}));  // a common edge
  EXPECT_TRUE(FacesCross(vertices, {0, 1, 2}, {0, 4, 6}) ||
              FacesCross(vertices, {0, 1, 2}, {10, 4, 6}));  // a fin through it
}

}  // namespace
}  // namespace lsmvs
