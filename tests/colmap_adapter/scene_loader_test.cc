#include "lsmvs/colmap_adapter/scene_loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/adapter_test/analytic_workspace.h"
#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/adapter_test/small_model.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class SceneLoaderTest : public testing::Test {
 protected:
  SceneLoaderTest()
      : surface_(MakeSphere()), data_(MakeAnalyticWorkspace(folder_.path(), *surface_)) {}

  std::string Error() const {
    return InputErrorOf([&] { LoadScene(data_.workspace); });
  }
  std::filesystem::path FirstImage() const {
    return data_.workspace.ImagePath(data_.scene.views[0].name);
  }

  TemporaryFolder folder_;
  std::unique_ptr<AnalyticSurface> surface_;
  AnalyticWorkspace data_;
};

TEST_F(SceneLoaderTest, ViewsComeInRegisteredOrderWithTheirPoses) {
  const Scene& scene = data_.scene;
  ASSERT_EQ(scene.num_views(), 6);
  EXPECT_TRUE(scene.world_offset.isZero(0.0));
  for (size_t v = 0; v < 6; ++v) {
    EXPECT_EQ(scene.views[v].name, data_.model.images[v].name);
    EXPECT_EQ(scene.views[v].image_id, data_.model.images[v].image_id);
    EXPECT_EQ(scene.views[v].camera.width, 320);
  }
  // Points reproject onto their features.
  ASSERT_EQ(scene.points.size(), data_.model.points3d.size());
  for (size_t p = 0; p < scene.points.size(); ++p) {
    for (const SparseModel::TrackElement& element : data_.model.points3d[p].track) {
      for (size_t v = 0; v < 6; ++v) {
        if (scene.views[v].image_id != element.image_id) continue;
        const View& view = scene.views[v];
        const Eigen::Vector2d x =
            view.camera.Project(view.cam_from_world * scene.points[p].x_in_world);
        EXPECT_NEAR((x - data_.model.images[v].points2d[element.point2d_idx].x).norm(), 0, 1e-9);
      }
    }
  }
}

TEST_F(SceneLoaderTest, FramesDecideTheOrder) {
  AddTrivialRigsAndFrames(&data_.model);
  std::reverse(data_.model.frames.begin(), data_.model.frames.end());
  WriteSparseModel(data_.workspace.SparseFolder(), data_.model);
  const Scene scene = LoadScene(data_.workspace);
  for (size_t v = 0; v < 6; ++v) EXPECT_EQ(scene.views[v].name, data_.model.images[5 - v].name);
}

TEST_F(SceneLoaderTest, SimplePinholeIsTaken) {
  data_.model.cameras[0].model_id = 0;
  data_.model.cameras[0].params = {300, 160, 120};
  const Scene scene = MakeScene(data_.model, "model");
  EXPECT_EQ(scene.views[0].camera.fx, 300);
  EXPECT_EQ(scene.views[0].camera.fy, 300);
  EXPECT_EQ(scene.views[0].camera.cx, 160);
  EXPECT_EQ(scene.views[0].camera.cy, 120);
}

TEST_F(SceneLoaderTest, OtherCamerasAreRefusedByName) {
  data_.model.cameras[0] = {CameraId{3}, 2, 320, 240, {300, 160, 120, 0.01}};
  EXPECT_THAT(InputErrorOf([&] { MakeScene(data_.model, "model"); }),
              HasSubstr("model: camera 3 is of the model SIMPLE_RADIAL; dense reconstruction needs "
                        "PINHOLE; undistort with"));
  data_.model.cameras[0] = {CameraId{3}, 17, 320, 240, {1, 2}};
  EXPECT_THAT(InputErrorOf([&] { MakeScene(data_.model, "model"); }),
              AllOf(HasSubstr("EQUIRECTANGULAR"), HasSubstr("panoramas")));
  data_.model.cameras[0] = {CameraId{3}, 0, 320, 240, {-300, 160, 120}};
  EXPECT_THAT(InputErrorOf([&] { MakeScene(data_.model, "model"); }), HasSubstr("focal length"));
}

TEST_F(SceneLoaderTest, UnusedCamerasDoNotMatter) {
  data_.model.cameras.push_back({CameraId{9}, 2, 320, 240, {300, 160, 120, 0.01}});
  EXPECT_EQ(MakeScene(data_.model, "model").num_views(), 6);
}

TEST_F(SceneLoaderTest, ViewsOfAPointAreAscendingWithoutDuplicates) {
  auto& track = data_.model.points3d[0].track;
  std::reverse(track.begin(), track.end());
  track.push_back(track.front());
  const Scene scene = MakeScene(data_.model, "model");
  EXPECT_EQ(scene.points[0].view_idxs, data_.scene.points[0].view_idxs);
}

// Moves the whole model.
void Translate(const Eigen::Vector3d& by, SparseModel* model) {
  for (SparseModel::Image& image : model->images) {
    image.cam_from_world.translation -= image.cam_from_world.rotation * by;
  }
  for (SparseModel::Point3d& point : model->points3d) point.x_in_world += by;
}

TEST_F(SceneLoaderTest, UtmCoordinatesAreShifted) {
  const Eigen::Vector3d utm(448251.5, 5411932.25, 320.5);
  Translate(utm, &data_.model);
  const Scene scene = MakeScene(data_.model, "model");
  EXPECT_LT((scene.world_offset - utm).norm(), 10);
  EXPECT_EQ(scene.world_offset, scene.world_offset.array().round().matrix());
  for (size_t p = 0; p < scene.points.size(); ++p) {
    const Eigen::Vector3d x = scene.points[p].x_in_world + scene.world_offset - utm;
    EXPECT_LT((x - data_.scene.points[p].x_in_world).norm(), 1e-8);
    // Float positions of the shifted scene hold a thousandth of a pixel.
    EXPECT_LT((scene.points[p].x_in_world.cast<float>().cast<double>() - scene.points[p].x_in_world)
                  .norm(),
              1e-3 * GroundSamplingDistance(scene));
  }
  for (const View& view : scene.views) {
    const View& original = data_.scene.views[static_cast<size_t>(&view - scene.views.data())];
    EXPECT_LT((view.CenterInWorld() + scene.world_offset - utm - original.CenterInWorld()).norm(),
              1e-7);
  }
}

TEST_F(SceneLoaderTest, OrdinaryScenesAreNotShifted) {
  Translate({20, -30, 5}, &data_.model);
  EXPECT_TRUE(MakeScene(data_.model, "model").world_offset.isZero(0.0));
}

TEST_F(SceneLoaderTest, EmptyPointsAreLegalAndNoImagesAreNot) {
  data_.model.points3d.clear();
  EXPECT_EQ(MakeScene(data_.model, "model").num_views(), 6);
  data_.model.images.clear();
  EXPECT_THAT(InputErrorOf([&] { MakeScene(data_.model, "model"); }),
              HasSubstr("has no registered image"));
}

TEST_F(SceneLoaderTest, MissingImagesAreNamed) {
  const std::string first = data_.scene.views[0].name, second = data_.scene.views[1].name;
  std::filesystem::remove(FirstImage());
  EXPECT_THAT(Error(), HasSubstr("images: 1 of the model's 6 photos is missing: " + first));
  std::filesystem::rename(data_.workspace.ImagePath(second),
                          data_.workspace.ImageFolder() / "VIEW3.PNG");
  EXPECT_THAT(Error(), AllOf(HasSubstr("2 of the model's 6 photos are missing"),
                             HasSubstr(second + " (there is VIEW3.PNG)"),
                             HasSubstr("--skip_missing_images")));
  EXPECT_EQ(LoadScene(data_.workspace, {.check_images = false}).num_views(), 6);
  std::filesystem::remove_all(data_.workspace.ImageFolder());
  EXPECT_THAT(Error(), HasSubstr("folder of the images is missing"));
  EXPECT_EQ(LoadScene(data_.workspace, {.check_images = false}).num_views(), 6);
}

TEST_F(SceneLoaderTest, MissingImagesMayBeSkipped) {
  std::filesystem::remove(FirstImage());
  const Scene scene = LoadScene(data_.workspace, {.skip_missing_images = true});
  EXPECT_EQ(scene.num_views(), 6);
  EXPECT_FALSE(scene.views[0].has_photo);
  EXPECT_TRUE(scene.views[1].has_photo);
  for (const SparsePoint& point : scene.points) {
    EXPECT_EQ(std::count(point.view_idxs.begin(), point.view_idxs.end(), 0), 0);
  }
  for (size_t v = 1; v < 5; ++v) {
    std::filesystem::remove(data_.workspace.ImagePath(data_.scene.views[v].name));
  }
  EXPECT_THAT(InputErrorOf([&] { LoadScene(data_.workspace, {.skip_missing_images = true}); }),
              HasSubstr("5 of the model's 6 photos are missing"));
}

TEST_F(SceneLoaderTest, DistortionMayBeIgnored) {
  data_.model.cameras[0] = {CameraId{3}, 4, 320, 240, {300, 310, 160, 120, 0.1, 0.1, 0, 0}};
  EXPECT_EQ(MakeScene(data_.model, "model", true).views[0].camera.fy, 310);
  data_.model.cameras[0] = {CameraId{3}, 3, 320, 240, {300, 160, 120, 0.1, 0.1}};
  EXPECT_EQ(MakeScene(data_.model, "model", true).views[0].camera.cx, 160);
}

TEST_F(SceneLoaderTest, MasksAreCheckedWithThePhotos) {
  LoadSceneOptions options;
  options.mask_folder = (folder_.path() / "masks").string();
  std::filesystem::create_directory(options.mask_folder);
  const std::string name = data_.scene.views[2].name;
  const auto mask = std::filesystem::path(options.mask_folder) / (name + ".png");
  WritePng(mask, ColorImage(160, 120, Color::Zero()));
  EXPECT_THAT(InputErrorOf([&] { LoadScene(data_.workspace, options); }),
              AllOf(HasSubstr(mask.string()), HasSubstr("160 x 120"), HasSubstr("mask")));
  WritePng(mask, ColorImage(320, 240, Color::Zero()));
  LoadScene(data_.workspace, options);
}

TEST_F(SceneLoaderTest, ImagesOfAnotherSizeAreNamed) {
  WritePng(FirstImage(), ColorImage(160, 120, Color::Zero()));
  EXPECT_THAT(Error(), HasSubstr(FirstImage().string() + ": is 160 x 120 pixels, but its camera is "
                                                         "320 x 240"));
}

TEST_F(SceneLoaderTest, CorruptImagesAreNamed) {
  const std::string bytes = ReadWholeFile(FirstImage());
  WriteWholeFile(FirstImage(), bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(Error(), HasSubstr(FirstImage().string() + ": is cut off"));
  WriteWholeFile(FirstImage(), "not an image");
  EXPECT_THAT(Error(), HasSubstr(FirstImage().string() + ": cannot be decoded"));
  WriteWholeFile(FirstImage(), "");
  EXPECT_THAT(Error(), HasSubstr(FirstImage().string() + ": cannot be decoded"));
}

TEST_F(SceneLoaderTest, MaskFolderMustBeThere) {
  LoadSceneOptions options;
  options.mask_folder = (folder_.path() / "masks").string();
  EXPECT_THAT(InputErrorOf([&] { LoadScene(data_.workspace, options); }), HasSubstr("--mask_path"));
  std::filesystem::create_directory(options.mask_folder);
  EXPECT_EQ(LoadScene(data_.workspace, options).mask_folder, options.mask_folder);
}

TEST(SceneLoaderRealTest, RealScenesLoad) {
  LSMVS_REQUIRE_SCENE("fountain-P11");
  const Scene scene = LoadScene({TestDataFolder() / "fountain-P11"});
  EXPECT_EQ(scene.num_views(), 11);
  EXPECT_TRUE(scene.world_offset.isZero(0.0));
  double sum = 0;
  size_t count = 0;
  for (const SparsePoint& point : scene.points) {
    sum += point.error_px;
    count += point.view_idxs.size();
    for (const int v : point.view_idxs) EXPECT_GT(scene.views[v].Depth(point.x_in_world), 0);
  }
  EXPECT_GT(count, 2 * scene.points.size());
  EXPECT_LT(sum / static_cast<double>(scene.points.size()), 2.0);
}

}  // namespace
}  // namespace lsmvs
