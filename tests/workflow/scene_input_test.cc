#include "lsmvs/workflow/files/scene_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Scene SceneOf(const std::vector<std::string>& names) {
  Scene scene;
  for (const std::string& name : names) {
    scene.views.emplace_back();
    scene.views.back().name = name;
  }
  return scene;
}

TEST(FindViews, GivesPositionsInOrderAndOnce) {
  const Scene scene = SceneOf({"left.jpg", "middle.jpg", "right.jpg"});
  EXPECT_THAT(FindViews(scene, {"right.jpg", "left.jpg", "right.jpg"}), ElementsAre(0, 2));
  EXPECT_THAT(FindViews(scene, {}), IsEmpty());
}

TEST(FindViews, SuggestsTheNearestName) {
  const Scene scene = SceneOf({"left.jpg", "right.jpg"});
  try {
    FindViews(scene, {"righ.jpg"});
    FAIL() << "there is no such photo";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'right.jpg'?"));
  }
}

TEST(LoadSceneIfGiven, AnEmptyPathIsNoScene) {
  const std::optional<Scene> scene = LoadSceneIfGiven("", true);
  EXPECT_FALSE(scene);
  EXPECT_TRUE(WorldOffset(scene).isZero(0));
}

TEST(ParseDirection, HasUnitLengthAndRefusesWhatIsNone) {
  EXPECT_TRUE(ParseDirection("up", "0,0,3").isApprox(Eigen::Vector3d(0, 0, 1)));
  for (const char* bad : {"", "1,2", "0,0,0", "1,2,3,4", "a,b,c", "inf,0,0"}) {
    EXPECT_THROW(ParseDirection("up", bad), UsageError) << bad;
  }
}

}  // namespace
}  // namespace lsmvs
