#include "lsmvs/colmap_adapter/scene_keypoints.h"

#include <gtest/gtest.h>

#include <fstream>

#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

TEST(SceneKeypoints, JoinOnlyWhereTheyAreThoseOfThePhotos) {
  LSMVS_REQUIRE_SCENE("fountain-P11");
  const DenseWorkspace workspace{TestDataFolder() / "fountain-P11"};
  Scene scene = LoadScene(workspace, {.mask_folder = "", .check_images = false});
  scene.views[1].name = "unknown to the database.jpg";
  // As if the photo had been undistorted by ten pixels.
  scene.views[2].camera.cx += 10;
  const auto keypoints = ReadSceneKeypoints(FindDatabase(workspace), scene);
  ASSERT_EQ(keypoints.size(), scene.views.size());
  for (int v = 0; v < scene.num_views(); ++v) {
    const bool fits = v != 1 && v != 2;
    EXPECT_EQ(keypoints[static_cast<size_t>(v)].size() > 1000, fits) << v;
  }
  scene.points.clear();  // nothing says that they fit
  for (const auto& list : ReadSceneKeypoints(FindDatabase(workspace), scene)) {
    EXPECT_TRUE(list.empty());
  }
}

TEST(SceneKeypoints, DatabaseIsThatOfTheWorkspaceOrItsProject) {
  const TemporaryFolder project;
  const std::filesystem::path dense = project.path() / "dense" / "0";
  std::filesystem::create_directories(dense);
  EXPECT_TRUE(FindDatabase({dense}).empty());
  std::ofstream(project.path() / "database.db") << "x";
  EXPECT_EQ(FindDatabase({dense}), project.path() / "database.db");
  EXPECT_EQ(FindDatabase({dense / ""}), project.path() / "database.db");
  EXPECT_EQ(FindDatabase({project.path()}), project.path() / "database.db");
  EXPECT_TRUE(FindDatabase({project.path() / "dense"}).empty());
  EXPECT_THROW(ReadSceneKeypoints(project.path() / "database.db", Scene()), InputError);
  EXPECT_THROW(ReadSceneKeypoints(project.path() / "none.db", Scene()), InputError);
}

}  // namespace
}  // namespace lsmvs
