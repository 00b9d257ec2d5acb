#include "lsmvs/scene/source_rules.h"

#include <gtest/gtest.h>

#include "lsmvs/scene/center_groups.h"

namespace lsmvs {
namespace {

using Kind = SourceRule::Kind;

// Views along a line, one unit apart.
Scene LineScene(int count) {
  Scene scene;
  for (int v = 0; v < count; ++v) {
    scene.views.emplace_back();
    scene.views.back().cam_from_world.translation = Eigen::Vector3d(-v, 0, 0);
  }
  return scene;
}

std::vector<int> ViewsOf(const std::vector<Neighbor>& neighbors) {
  std::vector<int> views;
  for (const Neighbor& n : neighbors) views.push_back(n.view_idx);
  return views;
}

std::vector<std::vector<Neighbor>> Apply(const Scene& scene, const std::vector<SourceRule>& rules) {
  std::vector<std::vector<Neighbor>> neighbors(scene.views.size(),
                                               {{3, 2.0, 5, 9}, {1, 1.0, 5, 9}});
  neighbors[3] = {{0, 2.0, 5, 9}};
  ApplySourceRules(scene, rules, &neighbors);
  return neighbors;
}

TEST(SourceRules, EachKindDoesWhatItSays) {
  const Scene scene = LineScene(5);
  const auto neighbors = Apply(scene, {{Kind::kAll, 0, {}},
                                       {Kind::kListed, 0, {4, 1, 0, 4}},
                                       {Kind::kBest, 1, {}},
                                       {Kind::kNone, 0, {}},
                                       {Kind::kBest, 0, {}}});
  EXPECT_EQ(ViewsOf(neighbors[0]), (std::vector<int>{3, 1, 2, 4}));
  EXPECT_EQ(ViewsOf(neighbors[1]), (std::vector<int>{4, 0}));
  EXPECT_EQ(ViewsOf(neighbors[2]), (std::vector<int>{3}));
  EXPECT_TRUE(neighbors[3].empty());
  EXPECT_EQ(ViewsOf(neighbors[4]), (std::vector<int>{3, 1}));
  for (size_t i = 1; i < neighbors[0].size(); ++i) {
    EXPECT_LT(neighbors[0][i].score, neighbors[0][i - 1].score);
  }
}

TEST(SourceRules, ViewsWithoutPhotoAreNobodysNeighbors) {
  Scene scene = LineScene(5);
  scene.views[3].has_photo = false;
  const auto neighbors = Apply(scene, {});
  EXPECT_EQ(ViewsOf(neighbors[0]), (std::vector<int>{1}));
  EXPECT_TRUE(neighbors[3].empty());
}

TEST(SourceRules, ColmapsDefaultChangesNothing) {
  EXPECT_TRUE(ChangeNothing({}, 8));
  EXPECT_TRUE(ChangeNothing({{Kind::kBest, 20, {}}, {Kind::kBest, 8, {}}}, 8));
  EXPECT_FALSE(ChangeNothing({{Kind::kBest, 20, {}}, {Kind::kBest, 7, {}}}, 8));
  EXPECT_FALSE(ChangeNothing({{Kind::kAll, 0, {}}}, 8));
}

TEST(CenterGroups, CropsOfAPanoramaShareAPlaceAtAnyScale) {
  for (const double scale : {1.0, 1e-3, 1e5}) {
    Scene scene;
    for (int v = 0; v < 12; ++v) {
      View view;
      view.cam_from_world.rotation =
          Eigen::AngleAxisd(0.3 * v, Eigen::Vector3d::UnitY()).toRotationMatrix();
      const Eigen::Vector3d center(scale * (v / 3) * (1 + 1e-9 * v), 0, scale);
      view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
      scene.views.push_back(view);
    }
    EXPECT_EQ(CenterGroups(scene), (std::vector<int>{0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3}));
  }
  EXPECT_TRUE(CenterGroups(Scene()).empty());
}

}  // namespace
}  // namespace lsmvs
