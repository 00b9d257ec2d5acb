#include "lsmvs/colmap_adapter/depth_map_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <thread>

#include "lsmvs/adapter_test/analytic_workspace.h"
#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/scene/packed_depth_map.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;

constexpr DepthMapKind kType = DepthMapKind::kGeometric;

class DepthMapIoTest : public testing::Test {
 protected:
  DepthMapIoTest() {
    workspace_.folder = folder_.path();
    scene_.views = {{ImageId{1}, "sub/a b.jpg", {8, 6, 10, 11, 4, 3}, Rigid3()}};
  }

  const View& view() const { return scene_.views[0]; }
  std::filesystem::path DepthPath() const { return workspace_.DepthMapPath(view().name, kType); }
  std::filesystem::path NormalPath() const { return workspace_.NormalMapPath(view().name, kType); }

  // Each sample has its own depth and a tilted normal; one sample is unknown and one has no normal.
  static DepthMap SomeMap(int width, int height) {
    DepthMap map{Raster<float>(width, height), Raster<Eigen::Vector3f>(width, height)};
    for (int i = 0; i < width * height; ++i) {
      map.depth.pixels[static_cast<size_t>(i)] = 2.0f + 0.01f * static_cast<float>(i);
      map.normal.pixels[static_cast<size_t>(i)] =
          Eigen::Vector3f(0.01f * static_cast<float>(i), -0.2f, -1).normalized();
    }
    map.depth(1, 0) = 0;
    map.normal(1, 0).setZero();
    map.normal(2, 1).setZero();
    return map;
  }

  TemporaryFolder folder_;
  DenseWorkspace workspace_;
  Scene scene_;
};

TEST_F(DepthMapIoTest, ReadsWhatItWrote) {
  const DepthMap map = SomeMap(8, 6);
  EXPECT_FALSE(HasDepthMap(workspace_, view(), kType));
  WriteDepthMap(workspace_, view(), kType, map);
  EXPECT_TRUE(HasDepthMap(workspace_, view(), kType));
  const DepthMap read = ReadDepthMap(workspace_, view(), kType);
  ASSERT_EQ(read.depth.width, 8);
  ASSERT_EQ(read.depth.height, 6);
  for (size_t i = 0; i < map.depth.size(); ++i) {
    EXPECT_NEAR(read.depth.pixels[i], map.depth.pixels[i], 1e-6 * map.depth.pixels[i]);
    EXPECT_EQ(read.normal.pixels[i], map.normal.pixels[i]);
  }
}

TEST_F(DepthMapIoTest, BytesAreColmaps) {
  WriteDepthMap(workspace_, view(), kType, SomeMap(4, 3));
  const std::string depth = ReadWholeFile(DepthPath()), normal = ReadWholeFile(NormalPath());
  EXPECT_EQ(DepthPath(), folder_.path() / "stereo/depth_maps/sub/a b.jpg.geometric.bin");
  EXPECT_EQ(depth.substr(0, 6), "4&3&1&");
  EXPECT_EQ(depth.size(), 6 + 4 * 4 * 3);
  EXPECT_EQ(normal.substr(0, 6), "4&3&3&");
  EXPECT_EQ(normal.size(), 6 + 3 * 4 * 4 * 3);
  // Planar: the y components of all samples follow the x components.
  float y_of_first = 0;
  std::memcpy(&y_of_first, normal.data() + 6 + 4 * 12, 4);
  EXPECT_EQ(y_of_first, SomeMap(4, 3).normal(0, 0).y());
}

TEST_F(DepthMapIoTest, StoredDepthIsThatOfTheTangentPlaneAtThePixelCorner) {
  const DepthMap map = SomeMap(4, 3);
  WriteDepthMap(workspace_, view(), kType, map);
  const PinholeCamera camera = view().camera.Resized(4, 3);
  const std::string bytes = ReadWholeFile(DepthPath());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      float stored = 0;
      std::memcpy(&stored, bytes.data() + 6 + 4 * (4 * row + column), 4);
      const Eigen::Vector3d normal = map.normal(column, row).cast<double>();
      const Eigen::Vector3d x = map.depth(column, row) * camera.PixelRay(column, row);
      const Eigen::Vector3d moved = stored * camera.Ray(Eigen::Vector2d(column, row));
      EXPECT_NEAR(normal.dot(moved - x), 0, 1e-6);
      if (normal.isZero()) {
        EXPECT_EQ(stored, map.depth(column, row));
      }
    }
  }
}

TEST_F(DepthMapIoTest, SteepSamplesKeepTheirDepth) {
  DepthMap map = SomeMap(4, 3);
  for (Eigen::Vector3f& normal : map.normal.pixels) {
    normal = Eigen::Vector3f(1, 0, -0.02f).normalized();
  }
  const std::vector<float> before = map.depth.pixels;
  MoveSamplesToPixelCorners(view().camera, &map);
  for (int row = 0; row < 3; ++row) EXPECT_EQ(map.depth(2, row), before[map.depth.Index(2, row)]);
  for (const float depth : map.depth.pixels) EXPECT_LT(depth, 10.0f);
}

TEST_F(DepthMapIoTest, CleansWhatIsNotValid) {
  DepthMap map = SomeMap(4, 3);
  map.normal(0, 0) = {0, 0, -1};
  WriteDepthMap(workspace_, view(), kType, map);
  const auto patch = [](const std::filesystem::path& path, size_t index, float value) {
    std::string bytes = ReadWholeFile(path);
    std::memcpy(bytes.data() + 6 + 4 * index, &value, 4);
    WriteWholeFile(path, bytes);
  };
  patch(DepthPath(), 0, -1.0f);
  patch(DepthPath(), 3, std::nanf(""));
  patch(DepthPath(), 4, INFINITY);
  patch(NormalPath(), 5, std::nanf(""));
  patch(NormalPath(), 24 + 6, 0.5f);  // away from the camera
  const DepthMap read = ReadDepthMap(workspace_, view(), kType);
  for (const size_t i : {0, 3, 4}) EXPECT_EQ(read.depth.pixels[i], 0.0f);
  for (const size_t i : {5, 6}) EXPECT_TRUE(read.normal.pixels[i].isZero());
}

// Maps of learned stereo come without.
TEST_F(DepthMapIoTest, NormalsAreDerivedWhereTheirMapIsMissing) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  View large = view();
  large.camera = view().camera.Resized(40, 30);
  const PinholeCamera& camera = large.camera;
  DepthMap map;
  map.depth = Raster<float>(40, 30);
  map.normal = Raster<Eigen::Vector3f>(40, 30, normal.cast<float>());
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      const double step = column < 20 ? 4.0 : 6.0;  // two planes
      map.depth(column, row) =
          static_cast<float>(step * normal.z() / normal.dot(camera.PixelRay(column, row)));
    }
  }
  WriteDepthMap(workspace_, large, kType, map);
  std::filesystem::remove(NormalPath());
  EXPECT_TRUE(HasDepthMap(workspace_, large, kType));
  const DepthMap read = ReadDepthMap(workspace_, large, kType);
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      EXPECT_GT(read.normal(column, row).cast<double>().dot(normal), 0.9999);
      EXPECT_NEAR(read.depth(column, row), map.depth(column, row), 1e-4);
    }
  }
}

TEST_F(DepthMapIoTest, NoNormalsAreDerivedFromLonelySamples) {
  DepthMap map = SomeMap(4, 3);
  for (size_t i = 0; i < map.depth.size(); ++i) {
    map.depth.pixels[i] = i % 2 == 0 ? static_cast<float>(1 + i) : 0.0f;
  }
  WriteDepthMap(workspace_, view(), kType, map);
  std::filesystem::remove(NormalPath());
  const DepthMap read = ReadDepthMap(workspace_, view(), kType);
  for (const Eigen::Vector3f& normal : read.normal.pixels) EXPECT_TRUE(normal.isZero());
}

TEST_F(DepthMapIoTest, TruncationAtEveryByteIsAnErrorAndNotComplete) {
  WriteDepthMap(workspace_, view(), kType, SomeMap(4, 3));
  for (const auto& path : {DepthPath(), NormalPath()}) {
    ExpectErrorAtEveryTruncation(path, [&] {
      EXPECT_FALSE(HasDepthMap(workspace_, view(), kType));
      ReadDepthMap(workspace_, view(), kType);
    });
    ExpectSurvivesMutations(path, 300, [&] { ReadDepthMap(workspace_, view(), kType); });
  }
}

TEST_F(DepthMapIoTest, BadHeadersAreErrors) {
  WriteDepthMap(workspace_, view(), kType, SomeMap(4, 3));
  for (const char* header : {"", "4&3&2&", "4&3&1", "0&3&1&", "4 3 1 ", "-4&3&1&", "99999999&3&1&",
                             "1000000&1000000&1&", "&&&", "4&3&1&&"}) {
    WriteWholeFile(DepthPath(), header + std::string(48, '\0'));
    EXPECT_THAT(InputErrorOf([&] { ReadDepthMap(workspace_, view(), kType); }),
                HasSubstr("geometric.bin"))
        << header;
    EXPECT_FALSE(HasDepthMap(workspace_, view(), kType)) << header;
  }
}

TEST_F(DepthMapIoTest, SizesMustFit) {
  WriteDepthMap(workspace_, view(), kType, SomeMap(16, 12));
  EXPECT_THAT(InputErrorOf([&] { ReadDepthMap(workspace_, view(), kType); }),
              HasSubstr("16 x 12, larger than its image (8 x 6)"));
  WriteDepthMap(workspace_, view(), kType, SomeMap(4, 3));
  const std::string depth = ReadWholeFile(DepthPath());
  WriteDepthMap(workspace_, view(), kType, SomeMap(8, 6));
  WriteWholeFile(DepthPath(), depth);
  EXPECT_FALSE(HasDepthMap(workspace_, view(), kType));
  EXPECT_THAT(InputErrorOf([&] { ReadDepthMap(workspace_, view(), kType); }),
              HasSubstr("is 8 x 6, but the depth map is 4 x 3"));
}

TEST_F(DepthMapIoTest, SourceKeepsWithinItsBudget) {
  for (int v = 1; v < 4; ++v) {
    scene_.views.push_back(scene_.views[0]);
    scene_.views.back().name = std::to_string(v) + ".jpg";
  }
  for (int v = 0; v < 3; ++v) {
    WriteDepthMap(workspace_, scene_.views[static_cast<size_t>(v)], kType, SomeMap(8, 6));
  }
  const size_t map_bytes = 8 * 6 * PackedDepthMap::kBytesPerPixel;
  const auto source = MakeDepthMapSource(workspace_, scene_, kType, 2 * map_bytes);
  for (const int v : {0, 1, 0, 2}) ASSERT_NE(source->Get(v), nullptr);  // the last drops 1
  EXPECT_EQ(source->Get(3), nullptr);
  WriteDepthMap(workspace_, scene_.views[3], kType, SomeMap(8, 6));
  EXPECT_NE(source->Get(3), nullptr);  // drops 0
  // What is kept needs no file.
  std::filesystem::remove_all(workspace_.StereoFolder());
  EXPECT_EQ(source->Get(0), nullptr);
  EXPECT_EQ(source->Get(1), nullptr);
  EXPECT_NE(source->Get(2), nullptr);
  EXPECT_NE(source->Get(3), nullptr);
}

// Whether a map comes from the file or from the cache makes no difference.
TEST_F(DepthMapIoTest, SourceGivesTheSameMapEachTime) {
  WriteDepthMap(workspace_, view(), kType, SomeMap(8, 6));
  const DepthMap read = ReadDepthMap(workspace_, view(), kType);
  const auto cached = MakeDepthMapSource(workspace_, scene_, kType, 1 << 20);
  const auto uncached = MakeDepthMapSource(workspace_, scene_, kType, 0);
  const auto first = cached->Get(0);
  for (const auto& again : {cached->Get(0), uncached->Get(0), uncached->Get(0)}) {
    EXPECT_EQ(again->depth.pixels, first->depth.pixels);
    EXPECT_EQ(again->normal.pixels, first->normal.pixels);
  }
  EXPECT_EQ(first->depth.pixels, read.depth.pixels);
  for (size_t i = 0; i < read.normal.size(); ++i) {
    EXPECT_LT((first->normal.pixels[i] - read.normal.pixels[i]).norm(), 1e-4f) << i;
  }
}

TEST_F(DepthMapIoTest, SourceIsThreadSafe) {
  scene_.views.push_back(scene_.views[0]);
  scene_.views[1].name = "b.jpg";
  for (const View& v : scene_.views) WriteDepthMap(workspace_, v, kType, SomeMap(8, 6));
  const auto source = MakeDepthMapSource(workspace_, scene_, kType, 1);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 50; ++i) EXPECT_NE(source->Get((i + t) % 2), nullptr);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

// How far the samples, as COLMAP places them (on the rays through the pixels' corners), lie from
// the surface: the mean signed distance, with the sign turned where the surface faces the other
// way, so that the two sides of a sphere do not cancel.
double BiasOfStoredSamples(const AnalyticWorkspace& data, const AnalyticSurface& surface,
                           int view_idx, const DepthMap& stored) {
  constexpr float kMinFacing = 0.3f;
  const View& view = data.scene.views[static_cast<size_t>(view_idx)];
  const PinholeCamera camera = view.camera.Resized(stored.depth.width, stored.depth.height);
  double sum = 0;
  size_t count = 0;
  for (int row = 0; row < stored.depth.height; ++row) {
    for (int column = 0; column < stored.depth.width; ++column) {
      const Eigen::Vector3f& normal = stored.normal(column, row);
      if (normal.z() > -kMinFacing) continue;
      const Eigen::Vector3d x_in_cam =
          stored.depth(column, row) * camera.Ray(Eigen::Vector2d(column, row));
      const double distance = surface.SignedDistance(view.cam_from_world.Inverse() * x_in_cam);
      sum += normal.x() + normal.y() < 0 ? distance : -distance;
      ++count;
    }
  }
  return sum / static_cast<double>(count);
}

TEST(HalfPixelTest, PlaneAndSphereSurviveWithoutBias) {
  for (const auto& surface : {MakePlane(), MakeSphere()}) {
    const TemporaryFolder folder;
    const AnalyticWorkspace data = MakeAnalyticWorkspace(folder.path(), *surface);
    const double gsd = GroundSamplingDistance(data.scene);
    for (const int scale : {1, 2}) {
      DepthMap map = data.TrueDepthMap(*surface, 0, 320 / scale, 240 / scale);
      // Taken as they are, the samples would lie beside the surface.
      EXPECT_GT(std::abs(BiasOfStoredSamples(data, *surface, 0, map)), 0.15 * scale * gsd);
      MoveSamplesToPixelCorners(data.scene.views[0].camera, &map);
      EXPECT_LT(std::abs(BiasOfStoredSamples(data, *surface, 0, map)), 0.02 * scale * gsd);
    }
  }
}

}  // namespace
}  // namespace lsmvs
