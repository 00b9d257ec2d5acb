#include "lsmvs/mesh/undo_collisions.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {
namespace {

using Vertices = std::vector<Eigen::Vector3d>;
using Faces = std::vector<Eigen::Vector3i>;

void AddSheet(int n, double z, Vertices* vertices, Faces* faces) {
  const int first = static_cast<int>(vertices->size());
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) vertices->push_back({x + 0.3 * z, y + 0.17 * z, z});
  }
  for (int y = 0; y + 1 < n; ++y) {
    for (int x = 0; x + 1 < n; ++x) {
      const int a = first + y * n + x;
      faces->push_back({a, a + 1, a + n});
      faces->push_back({a + 1, a + n + 1, a + n});
    }
  }
}

// Two sheets one unit apart, the lower pushed through the upper one in the middle.
TEST(UndoCollisions, TakesBackWhatWentThroughAndNothingElse) {
  Vertices before;
  Faces faces;
  AddSheet(20, 0, &before, &faces);
  AddSheet(20, 1, &before, &faces);
  Vertices after = before;
  for (size_t v = 0; v < 400; ++v) {
    const double distance = (before[v] - Eigen::Vector3d(9.3, 9.6, 0)).norm();
    after[v].z() += distance < 3 ? 1.5 : 0.2;
  }
  const Vertices pushed = after;
  const std::vector<uint8_t> all(faces.size(), 1);
  ASSERT_FALSE(FaceGrid(after, faces).CrossingPairs(all, RunContext(1)).empty());
  const size_t count = UndoCollisions(faces, before, &after, RunContext(2));
  EXPECT_TRUE(FaceGrid(after, faces).CrossingPairs(all, RunContext(1)).empty());
  EXPECT_GT(count, 10u);
  size_t num_back = 0;
  for (size_t v = 0; v < after.size(); ++v) {
    const bool is_back = after[v] == before[v] && pushed[v] != before[v];
    num_back += is_back;
    EXPECT_TRUE(is_back || after[v] == pushed[v]);
    EXPECT_TRUE(!is_back || (before[v] - Eigen::Vector3d(9.3, 9.6, 0)).norm() < 6);
  }
  EXPECT_EQ(num_back, count);
}

TEST(UndoCollisions, LeavesAHarmlessStepAndCrossingsOfTheInputAlone) {
  Vertices before;
  Faces faces;
  AddSheet(8, 0, &before, &faces);
  before.insert(before.end(), {{2.2, 2.3, -1}, {2.6, 2.3, 1}, {2.4, 2.9, 1}});
  faces.emplace_back(64, 65, 66);
  Vertices after = before;
  for (Eigen::Vector3d& x : after) x += Eigen::Vector3d(0.3, 0.1, 0.7);
  const Vertices moved = after;
  EXPECT_EQ(UndoCollisions(faces, before, &after, RunContext(1)), 0u);
  EXPECT_EQ(after, moved);
  EXPECT_EQ(UndoCollisions({}, {}, &after, RunContext(1)), 0u);
}

}  // namespace
}  // namespace lsmvs
