#include "lsmvs/synthetic/photo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lsmvs/image/sampling.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

GrayImage ToGray(const ColorImage& image) {
  GrayImage gray(image.width, image.height);
  for (size_t i = 0; i < image.size(); ++i) {
    const Eigen::Vector3f c = image.pixels[i].cast<float>();
    gray.pixels[i] = 0.299f * c[0] + 0.587f * c[1] + 0.114f * c[2];
  }
  return gray;
}

struct Moments {
  double mean = 0, deviation = 0;
};

Moments MomentsOf(const std::vector<double>& values) {
  Moments m;
  for (const double v : values) m.mean += v / static_cast<double>(values.size());
  for (const double v : values) m.deviation += (v - m.mean) * (v - m.mean);
  m.deviation = std::sqrt(m.deviation / static_cast<double>(values.size()));
  return m;
}

// Pairs of grey values at the same surface points in two photos, through the true depth.
struct Pairs {
  std::vector<double> a, b;
};

Pairs Correspondences(const SyntheticScene& s, const GrayImage& a, const GrayImage& b, int view_a,
                      int view_b) {
  Pairs pairs;
  const View& va = s.scene.views[view_a];
  const View& vb = s.scene.views[view_b];
  const DepthMap map = TrueDepthMap(*s.shape, va, RunContext());
  for (int row = 0; row < a.height; row += 2) {
    for (int column = 0; column < a.width; column += 2) {
      if (map.depth(column, row) == 0) continue;
      const Eigen::Vector3d x =
          va.cam_from_world.Inverse() * (map.depth(column, row) * va.camera.PixelRay(column, row));
      const Eigen::Vector3d normal =
          va.cam_from_world.rotation.transpose() * map.normal(column, row).cast<double>();
      if (!SeesSurfacePoint(*s.shape, va, x, normal, 60)) continue;
      if (!SeesSurfacePoint(*s.shape, vb, x, normal, 60)) continue;
      const Eigen::Vector2d p = vb.camera.Project(vb.cam_from_world * x);
      if (!InsideForSampling(b, p.x(), p.y())) continue;
      pairs.a.push_back(a(column, row));
      pairs.b.push_back(SampleBilinear(b, p.x(), p.y()).value);
    }
  }
  return pairs;
}

double Correlation(const Pairs& pairs) {
  const Moments a = MomentsOf(pairs.a), b = MomentsOf(pairs.b);
  double sum = 0;
  for (size_t i = 0; i < pairs.a.size(); ++i) sum += (pairs.a[i] - a.mean) * (pairs.b[i] - b.mean);
  return sum / (static_cast<double>(pairs.a.size()) * a.deviation * b.deviation);
}

TEST(Texture, NoiseIsSmoothAndCentred) {
  Random random(1);
  std::vector<double> values;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d x = 100 * random.Gaussian3();
    const double value = GradientNoise(x, 3);
    EXPECT_LE(std::abs(value), 1.2);
    EXPECT_NEAR(GradientNoise(x + Eigen::Vector3d(1e-6, 0, 0), 3), value, 1e-5);
    values.push_back(value);
  }
  EXPECT_NEAR(MomentsOf(values).mean, 0.0, 0.02);
  EXPECT_NEAR(MomentsOf(values).deviation, 0.27, 0.05);
}

TEST(Texture, FineOctavesFadeWithTheFootprint) {
  TextureOptions options;
  options.coarsest_wavelength = 1.0;
  options.finest_wavelength = 0.01;
  const SolidTexture texture(options);
  Random random(2);
  const auto roughness = [&](double footprint) {
    double sum = 0;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d x = random.Gaussian3();
      sum += std::abs(texture.Albedo(x, footprint)[1] -
                      texture.Albedo(x + Eigen::Vector3d(0.01, 0, 0), footprint)[1]);
    }
    return sum / 500;
  };
  const double sharp = roughness(0.001), blurred = roughness(0.05);
  EXPECT_GT(sharp, 3 * blurred);
  EXPECT_LT(roughness(10.0), 1e-6);
}

TEST(Texture, WeakZonesTakeTheShareAskedFor) {
  TextureOptions options;
  options.weak_fraction = 0.3;
  options.weak_zone_size = 0.5;
  const SolidTexture texture(options);
  Random random(3);
  double weak = 0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) weak += texture.Strength(50 * random.Gaussian3()) < 0.5;
  EXPECT_NEAR(weak / kCount, 0.3, 0.04);
}

TEST(Photo, TheSamePointLooksTheSameInAllViews) {
  for (const ShapeName name : {ShapeName::kSphere, ShapeName::kStep, ShapeName::kTerrain}) {
    const SyntheticScene s = MakeScene(name, 12, 160, 120);
    const GrayImage a = ToGray(RenderPhoto(*s.shape, s.scene, 0, s.photo, RunContext()));
    const GrayImage b = ToGray(RenderPhoto(*s.shape, s.scene, 1, s.photo, RunContext()));
    const Pairs pairs = Correspondences(s, a, b, 0, 1);
    ASSERT_GT(pairs.a.size(), 500u);
    EXPECT_GT(Correlation(pairs), 0.95);
    EXPECT_GT(MomentsOf(pairs.a).deviation, 20.0);
  }
}

TEST(Photo, HasNoShiftAgainstTheTruth) {
  // Correlation through the true depth must be best without an image shift, in both directions.
  const SyntheticScene s = MakeScene(ShapeName::kStep, 12, 160, 120);
  const GrayImage a = ToGray(RenderPhoto(*s.shape, s.scene, 0, s.photo, RunContext()));
  const GrayImage b = ToGray(RenderPhoto(*s.shape, s.scene, 1, s.photo, RunContext()));
  const double best = Correlation(Correspondences(s, a, b, 0, 1));
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0.3, 0), Eigen::Vector2d(-0.3, 0),
                                       Eigen::Vector2d(0, 0.3), Eigen::Vector2d(0, -0.3)}) {
    SyntheticScene shifted = s;
    shifted.scene.views[1].camera.cx += shift.x();
    shifted.scene.views[1].camera.cy += shift.y();
    EXPECT_LT(Correlation(Correspondences(shifted, a, b, 0, 1)), best);
  }
}

TEST(Photo, SensorNoiseGainAndOffset) {
  const SyntheticScene s = MakeScene(ShapeName::kSphere, 6, 96, 72);
  PhotoOptions options = s.photo;
  const GrayImage clean = ToGray(RenderPhoto(*s.shape, s.scene, 0, options, RunContext()));
  options.noise_sigma = 3;
  const ColorImage noisy = RenderPhoto(*s.shape, s.scene, 0, options, RunContext());
  const ColorImage plain = RenderPhoto(*s.shape, s.scene, 0, s.photo, RunContext());
  std::vector<double> differences;
  for (size_t i = 0; i < noisy.size(); ++i) {
    differences.push_back(static_cast<double>(noisy.pixels[i][1]) - plain.pixels[i][1]);
  }
  EXPECT_NEAR(MomentsOf(differences).mean, 0.0, 0.15);
  EXPECT_NEAR(MomentsOf(differences).deviation, 3.0, 0.2);
  options.noise_sigma = 0;
  options.gain_sigma = 0.2;
  const GrayImage gained = ToGray(RenderPhoto(*s.shape, s.scene, 0, options, RunContext()));
  const double ratio = MomentsOf({gained.pixels.begin(), gained.pixels.end()}).mean /
                       MomentsOf({clean.pixels.begin(), clean.pixels.end()}).mean;
  EXPECT_GT(std::abs(ratio - 1), 0.005);
}

TEST(Photo, ExposureShadowAndHighlightChangeThePhoto) {
  const SyntheticScene s = MakeScene(ShapeName::kStep, 6, 96, 72);
  const auto mean = [&](const PhotoOptions& options, int view) {
    const GrayImage gray = ToGray(RenderPhoto(*s.shape, s.scene, view, options, RunContext()));
    return MomentsOf({gray.pixels.begin(), gray.pixels.end()}).mean;
  };
  PhotoOptions options = s.photo;
  options.exposure_step = 0.6;
  EXPECT_NEAR(mean(options, 0), mean(s.photo, 0), 1e-9);
  EXPECT_NEAR(mean(options, 1) / mean(s.photo, 1), 0.6, 0.01);
  options = s.photo;
  options.moving_shadow = 0.5;
  EXPECT_LT(mean(options, 0), 0.97 * mean(s.photo, 0));
  options = s.photo;
  options.specular = 0.5;
  options.specular_exponent = 10;
  EXPECT_GT(mean(options, 0), mean(s.photo, 0) + 1);
}

TEST(Photo, SameBytesForAnyNumberOfThreads) {
  const SyntheticScene s = MakeScene(ShapeName::kSphereOnGround, 6, 96, 72);
  PhotoOptions options = s.photo;
  options.noise_sigma = 2;
  const ColorImage one = RenderPhoto(*s.shape, s.scene, 2, options, RunContext(1));
  const ColorImage two = RenderPhoto(*s.shape, s.scene, 2, options, RunContext(2));
  EXPECT_EQ(one.pixels, two.pixels);
}

TEST(Photo, WrittenPhotosComeBackThroughTheImageStore) {
  SyntheticScene s = MakeScene(ShapeName::kSphere, 3, 64, 48);
  const TemporaryFolder folder;
  WritePhotos(*s.shape, s.photo, folder.path().string(), &s.scene, RunContext());
  const auto store = MakeImageStore(s.scene, ImageStoreOptions());
  const ColorImage expected = RenderPhoto(*s.shape, s.scene, 2, s.photo, RunContext());
  EXPECT_EQ(store->Colors(2, 0)->pixels, expected.pixels);
}

}  // namespace
}  // namespace lsmvs
