#include "lsmvs/colmap_adapter/files/compact_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

constexpr DepthMapKind kType = DepthMapKind::kGeometric;
constexpr double kDegree = 0.017453292519943295;

double AngleDegrees(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

// Towards the camera.
Eigen::Vector3f RandomNormal(std::mt19937* random) {
  std::normal_distribution<float> normal;
  Eigen::Vector3f n(normal(*random), normal(*random), normal(*random));
  n.z() = -std::abs(n.z()) - 1e-3f;
  return n.normalized();
}

TEST(CompactMap, NormalsTurnByLessThanAThirdOfADegree) {
  std::mt19937 random(1);
  for (int i = 0; i < 100000; ++i) {
    const Eigen::Vector3f normal = RandomNormal(&random);
    const Eigen::Vector3f rounded = internal::RoundNormal(normal);
    ASSERT_LT(AngleDegrees(normal, rounded), 0.33) << normal.transpose();
    ASSERT_LT(rounded.z(), 0);
    ASSERT_EQ(internal::RoundNormal(rounded), rounded);
  }
  EXPECT_TRUE(internal::RoundNormal(Eigen::Vector3f::Zero()).isZero(0.0f));
  EXPECT_LT(AngleDegrees(internal::RoundNormal({0, 0, -1}), {0, 0, -1}), 1e-3);
}

class CompactFiles : public testing::Test {
 protected:
  CompactFiles() { workspace_.folder = folder_.path(); }

  static DepthMap SomeMap(int width, int height) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> depth(1.0f, 20.0f);
    DepthMap map{Raster<float>(width, height), Raster<Eigen::Vector3f>(width, height)};
    for (float& value : map.depth.pixels) value = depth(random);
    for (Eigen::Vector3f& normal : map.normal.pixels) {
      normal = (RandomNormal(&random) + Eigen::Vector3f(0, 0, -2)).normalized();
    }
    map.depth(1, 0) = 0;
    map.normal(1, 0).setZero();
    return map;
  }

  std::filesystem::path DepthPath() const { return workspace_.DepthMapPath(view_.name, kType); }
  std::filesystem::path NormalPath() const { return workspace_.NormalMapPath(view_.name, kType); }

  TemporaryFolder folder_;
  DenseWorkspace workspace_;
  View view_{ImageId{1}, "a.jpg", {40, 30, 50, 51, 20, 15}, Rigid3()};
};

TEST_F(CompactFiles, AreReadWithinTheirPrecision) {
  const DepthMap map = SomeMap(40, 30);
  WriteDepthMap(workspace_, view_, kType, map, MapFormat::kCompact);
  ASSERT_TRUE(internal::IsCompactMap(DepthPath()));
  EXPECT_TRUE(HasDepthMap(workspace_, view_, kType));
  const DepthMap read = ReadDepthMap(workspace_, view_, kType);
  ASSERT_EQ(read.depth.width, 40);
  ASSERT_EQ(read.depth.height, 30);
  // Half of a step.
  const double precision = 0.5 * 0.05 / 40;
  for (size_t i = 0; i < map.depth.size(); ++i) {
    EXPECT_NEAR(read.depth.pixels[i], map.depth.pixels[i], precision * map.depth.pixels[i]);
    if (map.depth.pixels[i] > 0) {
      EXPECT_LT(AngleDegrees(read.normal.pixels[i], map.normal.pixels[i]), 0.25);
    }
  }
}

TEST_F(CompactFiles, OfLargeRangesHaveNoMoreThan65535Depths) {
  view_.camera = {400, 300, 500, 500, 200, 150};
  DepthMap map = SomeMap(400, 300);
  map.depth(0, 0) = 1e-3f;
  map.depth(399, 299) = 1e4f;
  WriteDepthMap(workspace_, view_, kType, map, MapFormat::kCompact);
  const DepthMap read = ReadDepthMap(workspace_, view_, kType);
  const double precision = 0.55 * std::log(1e7) / 65534;
  for (size_t i = 0; i < map.depth.size(); ++i) {
    ASSERT_NEAR(read.depth.pixels[i], map.depth.pixels[i], precision * map.depth.pixels[i]) << i;
  }
}

// A slanted plane with a hole: what the neighbours foretell is right but for rounding.
TEST_F(CompactFiles, OfSmoothSurfacesAreSmall) {
  constexpr int kWidth = 640, kHeight = 480;
  view_.camera = {kWidth, kHeight, 800, 800, 320, 240};
  DepthMap map{Raster<float>(kWidth, kHeight, 0.0f),
               Raster<Eigen::Vector3f>(kWidth, kHeight, Eigen::Vector3f(Eigen::Vector3f::Zero()))};
  const Eigen::Vector3f normal = Eigen::Vector3f(0.3f, -0.2f, -1).normalized();
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      if (std::hypot(column - 300, row - 200) < 50) continue;
      map.depth(column, row) = static_cast<float>(5 + 1e-3 * column + 2e-3 * row);
      map.normal(column, row) = normal;
    }
  }
  WriteDepthMap(workspace_, view_, kType, map, MapFormat::kCompact);
  const auto bytes =
      std::filesystem::file_size(DepthPath()) + std::filesystem::file_size(NormalPath());
  EXPECT_LT(static_cast<double>(bytes) / (kWidth * kHeight), 0.35);
  const DepthMap read = ReadDepthMap(workspace_, view_, kType);
  EXPECT_EQ(read.depth(300, 200), 0);
  EXPECT_TRUE(read.normal(300, 200).isZero(0.0f));
  EXPECT_GT(read.depth(0, 0), 0);
}

TEST_F(CompactFiles, ConvertBothWays) {
  const DepthMap map = SomeMap(40, 30);
  WriteDepthMap(workspace_, view_, kType, map);
  EXPECT_FALSE(ConvertDepthMap(workspace_, view_, kType, MapFormat::kColmap, workspace_));
  EXPECT_TRUE(ConvertDepthMap(workspace_, view_, kType, MapFormat::kCompact, workspace_));
  EXPECT_TRUE(internal::IsCompactMap(NormalPath()));
  const DepthMap compact = ReadDepthMap(workspace_, view_, kType);
  const std::string bytes = ReadWholeFile(DepthPath());
  EXPECT_TRUE(ConvertDepthMap(workspace_, view_, kType, MapFormat::kColmap, workspace_));
  EXPECT_FALSE(internal::IsCompactMap(NormalPath()));
  const DepthMap back = ReadDepthMap(workspace_, view_, kType);
  for (size_t i = 0; i < map.depth.size(); ++i) {
    EXPECT_NEAR(back.depth.pixels[i], compact.depth.pixels[i], 1e-6 * map.depth.pixels[i]);
  }
  EXPECT_TRUE(ConvertDepthMap(workspace_, view_, kType, MapFormat::kCompact, workspace_));
  EXPECT_EQ(ReadWholeFile(DepthPath()).size(), bytes.size());
}

TEST_F(CompactFiles, WithoutAnyDepthOrWithASingleOne) {
  DepthMap map{Raster<float>(5, 4, 0.0f),
               Raster<Eigen::Vector3f>(5, 4, Eigen::Vector3f(Eigen::Vector3f::Zero()))};
  WriteDepthMap(workspace_, view_, kType, map, MapFormat::kCompact);
  EXPECT_EQ(ReadDepthMap(workspace_, view_, kType).depth.pixels, map.depth.pixels);
  map.depth(3, 2) = 7.25f;
  WriteDepthMap(workspace_, view_, kType, map, MapFormat::kCompact);
  EXPECT_EQ(ReadDepthMap(workspace_, view_, kType).depth.pixels, map.depth.pixels);
}

TEST_F(CompactFiles, ThatAreCutOffOrDamagedAreRefused) {
  WriteDepthMap(workspace_, view_, kType, SomeMap(6, 5), MapFormat::kCompact);
  const auto read = [&] { ReadDepthMap(workspace_, view_, kType); };
  for (const auto& path : {DepthPath(), NormalPath()}) {
    ExpectErrorAtEveryTruncation(path, read);
    ExpectSurvivesMutations(path, 2000, read);
  }
  WriteWholeFile(DepthPath(), ReadWholeFile(DepthPath()).substr(0, 120));
  EXPECT_FALSE(HasDepthMap(workspace_, view_, kType));
}

// The header of the first format ends with the number of bytes.
TEST_F(CompactFiles, OfTheFirstFormatAreRefusedByTheirFormat) {
  WriteDepthMap(workspace_, view_, kType, SomeMap(6, 5), MapFormat::kCompact);
  std::string text = ReadWholeFile(DepthPath());
  const size_t last = text.rfind(" 2 ", 96);
  ASSERT_NE(last, std::string::npos);
  text[last + 1] = ' ';
  WriteWholeFile(DepthPath(), text);
  try {
    ReadDepthMap(workspace_, view_, kType);
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("format 1, not 2"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lsmvs
