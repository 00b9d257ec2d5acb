#include "lsmvs/stereo/patch_match/level_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

constexpr int kWidth = 96, kHeight = 64;
constexpr float kShiftPerInverseDepth = 40;  // pixels: focal length times base line
constexpr int kShift = 6;                    // of the plane that is seen

GrayImage Texture(uint64_t seed, int width) {
  GrayImage image(width, kHeight);
  Random random(seed);
  for (float& value : image.pixels) value = static_cast<float>(random.Below(256));
  return image;
}

// Two cameras to the right and the left of the reference look at a wall, at right angles.
class LevelMatcherTest : public testing::Test {
 protected:
  LevelMatcherTest() : reference_(kWidth, kHeight) {
    const GrayImage wall = Texture(1, kWidth + 4 * kShift);
    GrayImage right = reference_, left = reference_;
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        reference_(column, row) = wall(column + 2 * kShift, row);
        right(column, row) = wall(column + 3 * kShift, row);
        left(column, row) = wall(column + kShift, row);
      }
    }
    images_.emplace_back(right);
    images_.emplace_back(left);
    problem_.gray = &reference_;
    problem_.camera = {kWidth, kHeight, 100, 100, kWidth / 2.0, kHeight / 2.0};
    problem_.weights = PatchWeights({.half = 2, .step = 1}, 2.0, 51.0);
    for (int s = 0; s < 2; ++s) {
      SourceView source;
      source.image = &images_[static_cast<size_t>(s)];
      const float identity[9] = {1, 0, -0.5f, 0, 1, -0.5f, 0, 0, 1};
      std::copy(identity, identity + 9, source.m);
      source.e[0] = s == 0 ? -kShiftPerInverseDepth : kShiftPerInverseDepth;
      problem_.sources.push_back(source);
    }
  }

  LevelMatcher Matched(int num_threads) const {
    LevelMatcher matcher(problem_, 0.5f * kTruth, 2 * kTruth, 7);
    const RunContext context(num_threads);
    matcher.Start(PlaneMap(kWidth, kHeight), 2, context);
    SweepSettings settings;
    settings.num_random = 2;
    settings.num_perturbed = 2;
    for (int i = 0; i < 8; ++i) matcher.Sweep(settings, context);
    settings.parabola_px = 0.5f;
    matcher.Sweep(settings, context);
    return matcher;
  }

  static constexpr float kTruth = kShift / kShiftPerInverseDepth;  // inverse depth

  GrayImage reference_;
  std::vector<PackedImage> images_;
  MatchingProblem problem_;
};

TEST_F(LevelMatcherTest, FindsTheWallFromRandomPlanes) {
  const LevelMatcher matcher = Matched(1);
  int num_inner = 0, num_right = 0;
  for (int row = 4; row < kHeight - 4; ++row) {
    for (int column = 12; column < kWidth - 12; ++column) {
      const float error_px = kShiftPerInverseDepth * (matcher.planes()(column, row).q - kTruth);
      ++num_inner;
      num_right += std::abs(error_px) < 0.1f;
      EXPECT_LT(matcher.costs()(column, row), 1.2f);
    }
  }
  EXPECT_GT(num_right, 0.99 * num_inner);
}

TEST_F(LevelMatcherTest, ThreadsDoNotChangeThePlanes) {
  const LevelMatcher one = Matched(1), many = Matched(4);
  for (size_t i = 0; i < one.planes().pixels.size(); ++i) {
    ASSERT_EQ(one.planes().pixels[i].q, many.planes().pixels[i].q);
    ASSERT_EQ(one.planes().pixels[i].qx, many.planes().pixels[i].qx);
  }
}

// Where the source shows something else, no plane is left.
TEST_F(LevelMatcherTest, FilterDropsWhatDoesNotMatch) {
  LevelMatcher matcher = Matched(1);
  const auto known = [](const PlaneMap& planes) {
    return std::count_if(planes.pixels.begin(), planes.pixels.end(),
                         [](const Plane& plane) { return plane.known(); });
  };
  matcher.Filter({.min_zncc = 0.5f}, RunContext(1));
  EXPECT_GT(known(matcher.planes()), 0.8 * kWidth * kHeight);

  images_[0] = PackedImage(Texture(2, kWidth));
  images_[1] = PackedImage(Texture(3, kWidth));
  LevelMatcher lost = Matched(1);
  lost.Filter({.min_zncc = 0.8f}, RunContext(1));
  EXPECT_LT(known(lost.planes()), 0.1 * kWidth * kHeight);
}

}  // namespace
}  // namespace lsmvs
