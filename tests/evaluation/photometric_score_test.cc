#include "lsmvs/evaluation/photometric_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/test_evaluation/test_meshes.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

// A smooth random-looking texture on the plane z = 0.
double Texture(double x, double y) {
  return 128 + 40 * std::sin(3.1 * x + 1.7 * y) + 40 * std::sin(7.3 * y - 2.9 * x) +
         30 * std::sin(11 * x);
}

// Three photos of the plane z = 0 from above, 10 away.
struct PlaneScene {
  PlaneScene() {
    for (int i = 0; i < 3; ++i) {
      View view = test::DownwardView({5 + 0.8 * i, 5, 10}, 96, 80, 160);
      view.name = "photo" + std::to_string(i) + ".png";
      ColorImage image(view.camera.width, view.camera.height);
      for (int row = 0; row < image.height; ++row) {
        for (int column = 0; column < image.width; ++column) {
          const Eigen::Vector3d ray = 10 * view.camera.PixelRay(column, row);
          const Eigen::Vector3d x = view.cam_from_world.Inverse() * ray;
          image(column, row).setConstant(static_cast<uint8_t>(Texture(x.x(), x.y())));
        }
      }
      WritePng(folder.path() / view.name, image);
      scene.views.push_back(view);
    }
    scene.image_folder = folder.path().string();
  }

  PhotometricScore Score(double z, const PhotometricOptions& options,
                         const std::vector<int>& views = {}, int threads = 2,
                         double width = 20) const {
    const RunContext context(threads);
    const TriangleMesh mesh = test::Scaled(test::PlaneMesh(width, 20, z, 20), 1, {-3, -3, 0});
    const auto images = MakeImageStore(scene, {});
    return MeasurePhotometricScore(MeshTracer(mesh, context), mesh, scene, *images, views, true,
                                   options, context);
  }

  TemporaryFolder folder;
  Scene scene;
};

PhotometricOptions FullSize() {
  PhotometricOptions options;
  options.level = 0;
  return options;
}

TEST(PhotometricScore, TheTrueSurfaceCorrelates) {
  const PlaneScene plane;
  const PhotometricScore score = plane.Score(0, FullSize());
  EXPECT_GT(score.mean_zncc, 0.99);
  EXPECT_GT(score.median_zncc, 0.995);
  EXPECT_GT(score.coverage, 0.85);  // the outer photos see what no other does
  EXPECT_NEAR(score.score, score.coverage * score.mean_zncc, 1e-9);
  ASSERT_EQ(score.views.size(), 3u);
}

TEST(PhotometricScore, AWrongSurfaceDoesNot) {
  const PlaneScene plane;
  EXPECT_LT(plane.Score(3, FullSize()).score, 0.75 * plane.Score(0, FullSize()).score);
  EXPECT_GT(plane.Score(0, FullSize()).mean_zncc, plane.Score(0.1, FullSize()).mean_zncc);
}

TEST(PhotometricScore, AMissingPartLowersTheCoverage) {
  const PlaneScene plane;
  const PhotometricScore half =
      plane.Score(0, FullSize(), {1}, 2, 8.8);  // ends at the middle of view 1
  EXPECT_NEAR(half.coverage, 0.5, 0.06);
  EXPECT_GT(half.mean_zncc, 0.99);
}

TEST(PhotometricScore, HeldOutViewsOnly) {
  const PlaneScene plane;
  const PhotometricScore score = plane.Score(0, FullSize(), {2});
  ASSERT_EQ(score.views.size(), 1u);
  EXPECT_EQ(score.views[0].name, "photo2.png");
}

TEST(PhotometricScore, VerticesGetTheCorrelationOfTheViewsThatSeeThem) {
  const PlaneScene plane;
  const PhotometricScore score = plane.Score(0, FullSize());
  size_t seen = 0;
  for (const float zncc : score.vertex_zncc) {
    if (std::isnan(zncc)) continue;
    ++seen;
    EXPECT_GT(zncc, 0.9);
  }
  EXPECT_GT(seen, 10u);
  EXPECT_LT(seen, score.vertex_zncc.size());
}

TEST(PhotometricScore, ThreadsChangeNothing) {
  const PlaneScene plane;
  PhotometricOptions options;
  EXPECT_EQ(plane.Score(0.05, options, {}, 1).score, plane.Score(0.05, options, {}, 2).score);
}

TEST(PhotometricOptions, BoundsAreNamed) {
  std::string error;
  EXPECT_TRUE(PhotometricOptions().Check(&error));
  PhotometricOptions options;
  options.window = 8;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("window"), std::string::npos);
  options.window = 9;
  options.level = -1;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("level"), std::string::npos);
}

}  // namespace
}  // namespace lsmvs
