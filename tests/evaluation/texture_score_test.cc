#include "lsmvs/evaluation/texture_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_evaluation/test_meshes.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

Color Paint(const Eigen::Vector3d& x) {
  const double wave = 20 * std::sin(3.1 * x.x() + 1.7 * x.y()) + 20 * std::sin(5 * x.y());
  return Color(static_cast<uint8_t>(std::lround(120 + wave)),
               static_cast<uint8_t>(std::lround(100 + wave)),
               static_cast<uint8_t>(std::lround(130 - wave)));
}

struct PhotoFault {
  double gain = 1, bias = 0, noise = 0;
};

// A painted plane z = 0 and three photos of it from above, 10 away.
struct PaintedPlane {
  explicit PaintedPlane(const PhotoFault& fault) {
    Random random(7);
    for (int i = 0; i < 3; ++i) {
      View view = test::DownwardView({5 + 0.8 * i, 5, 10}, 96, 80, 160);
      view.name = "photo" + std::to_string(i) + ".png";
      ColorImage image(view.camera.width, view.camera.height);
      for (int row = 0; row < image.height; ++row) {
        for (int column = 0; column < image.width; ++column) {
          const Eigen::Vector3d x =
              view.cam_from_world.Inverse() * (10 * view.camera.PixelRay(column, row));
          for (int k = 0; k < 3; ++k) {
            const double value =
                fault.gain * Paint(x)[k] + fault.bias + fault.noise * random.Gaussian();
            image(column, row)[k] = static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L));
          }
        }
      }
      WritePng(folder.path() / view.name, image);
      scene.views.push_back(view);
    }
    scene.image_folder = folder.path().string();
  }

  TextureScore Score(double width = 20, const std::vector<int>& views = {}, int threads = 2) {
    const RunContext context(threads);
    const TriangleMesh mesh = test::Scaled(test::PlaneMesh(width, 20, 0, 4), 1, {-3, -3, 0});
    AtlasOptions atlas;
    atlas.page_width = atlas.page_height = 1400;
    atlas.chart_px = 200;
    const TexturedMesh textured = PaintAtlas(mesh, Paint, folder.path(), atlas);
    const TexturePages pages(textured, size_t{1} << 30);
    const auto images = MakeImageStore(scene, {});
    TextureScoreOptions options;
    options.antialiasing = 1;
    return MeasureTextureScore(MeshTracer(mesh, context), mesh, &pages, scene, *images, views,
                               options, context);
  }

  TemporaryFolder folder;
  Scene scene;
};

TEST(TextureScore, TrueTextureScoresWell) {
  const TextureScore score = PaintedPlane({}).Score();
  ASSERT_EQ(score.views.size(), 3u);
  EXPECT_EQ(score.num_scored_views, 3u);
  EXPECT_GT(score.psnr, 45);
  EXPECT_GT(score.ssim, 0.995);
  EXPECT_LT(score.one_minus_ncc, 0.01);
  EXPECT_EQ(score.completeness, 1);
  for (const TextureViewScore& view : score.views) {
    EXPECT_EQ(view.num_pixels, size_t{92 * 76});  // two pixels at the rim are left out
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(view.gain[k], 1, 0.01);
  }
}

TEST(TextureScore, GainAndBiasAreNoFault) {
  const TextureScore score = PaintedPlane({0.7, 12, 0}).Score();
  EXPECT_GT(score.psnr, 45);
  EXPECT_GT(score.ssim, 0.99);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(score.views[0].gain[k], 0.7, 0.01);
    EXPECT_NEAR(score.views[0].bias[k], 12, 1);
  }
}

// The error is the noise: PSNR = 20 log10(255 / sigma).
TEST(TextureScore, NoiseGivesItsOwnPsnr) {
  for (const double sigma : {4.0, 8.0}) {
    const TextureScore score = PaintedPlane({1, 0, sigma}).Score();
    EXPECT_NEAR(score.psnr, 20 * std::log10(255 / sigma), 0.3);
    EXPECT_LT(score.ssim, 0.97);
    EXPECT_GT(score.one_minus_ncc, 0.01);
  }
}

TEST(TextureScore, CompletenessIsTheShareThatTheMeshCovers) {
  // The first photo sees x in [2, 8]; the mesh ends at 4.
  const TextureScore score = PaintedPlane({}).Score(7, {0});
  ASSERT_EQ(score.views.size(), 1u);
  EXPECT_NEAR(score.completeness, 2.0 / 6, 0.02);
  EXPECT_GT(score.psnr, 45);
}

TEST(TextureScore, MeshThatNoPhotoSeesIsNotScored) {
  const TextureScore score = PaintedPlane({}).Score(1e-3, {0});
  EXPECT_EQ(score.num_scored_views, 0u);
  EXPECT_EQ(score.views[0].num_pixels, 0u);
}

TEST(TextureScore, SameForAnyNumberOfThreads) {
  PaintedPlane plane({0.9, 3, 5});
  const TextureScore one = plane.Score(20, {1}, 1), two = plane.Score(20, {1}, 2);
  EXPECT_EQ(one.psnr, two.psnr);
  EXPECT_EQ(one.ssim, two.ssim);
  EXPECT_EQ(one.one_minus_ncc, two.one_minus_ncc);
}

TEST(TextureScore, OptionsOutOfBounds) {
  std::string error;
  TextureScoreOptions options;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.level = -1;
  EXPECT_FALSE(options.Check(&error));
  options = {};
  options.antialiasing = 0;
  EXPECT_FALSE(options.Check(&error));
  options = {};
  options.margin = -1;
  EXPECT_FALSE(options.Check(&error));
}

}  // namespace
}  // namespace lsmvs
