#include "lsmvs/colmap_adapter/fused_cloud.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "lsmvs/adapter_test/analytic_workspace.h"
#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;

// The sparse points of a workspace as a cloud.
VisibilityCloud CloudOfSparsePoints(const Scene& scene, const AnalyticSurface& surface) {
  VisibilityCloud cloud;
  for (const SparsePoint& point : scene.points) {
    const std::vector<uint32_t> views(point.view_idxs.begin(), point.view_idxs.end());
    cloud.Add(point.x_in_world.cast<float>(), surface.Normal(point.x_in_world).cast<float>(),
              point.color, views);
  }
  return cloud;
}

void ExpectSameCloud(const VisibilityCloud& a, const VisibilityCloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.view_begin, b.view_begin);
  EXPECT_EQ(a.view_idxs, b.view_idxs);
}

class FusedCloudTest : public testing::Test {
 protected:
  FusedCloudTest()
      : surface_(MakeSphere()),
        data_(MakeAnalyticWorkspace(folder_.path(), *surface_)),
        cloud_(CloudOfSparsePoints(data_.scene, *surface_)),
        path_(data_.workspace.FusedPath()),
        vis_path_(DenseWorkspace::VisibilityPath(path_)) {}

  FusedCloud Read() const { return ReadFusedCloud(path_, data_.scene, data_.workspace); }
  std::string Error() const {
    return InputErrorOf([&] { Read(); });
  }

  TemporaryFolder folder_;
  std::unique_ptr<AnalyticSurface> surface_;
  AnalyticWorkspace data_;
  VisibilityCloud cloud_;
  std::filesystem::path path_, vis_path_;
};

TEST_F(FusedCloudTest, ReadsWhatItWrote) {
  ASSERT_GT(cloud_.size(), 50u);
  WriteFusedCloud(path_, cloud_, data_.scene);
  const FusedCloud read = Read();
  EXPECT_EQ(read.message, "");
  EXPECT_EQ(read.num_dropped, 0u);
  ExpectSameCloud(read.cloud, cloud_);
}

// Views behind those of the cloud that is there, points without position left out.
TEST_F(FusedCloudTest, AppendsAsOneCloudBehindTheOther) {
  VisibilityCloud expected = cloud_;
  VisibilityCloud moved = cloud_;
  const auto num_views = static_cast<uint32_t>(data_.scene.views.size());
  for (uint32_t& view_idx : moved.view_idxs) view_idx += num_views;
  expected.Append(moved);
  VisibilityCloud holed;
  holed.Add(Eigen::Vector3f::Constant(std::nanf("")), {0, 0, 1}, Color::Zero(),
            std::vector<uint32_t>{0, 1});
  holed.Append(cloud_);
  WriteFusedCloud(path_, holed, data_.scene);
  VisibilityCloud read;
  for (const uint32_t first_view : {0u, num_views}) {
    const AppendedCloud appended =
        AppendFusedCloud(path_, data_.scene, data_.workspace, first_view, &read);
    EXPECT_EQ(appended.num_dropped, 1u);
    EXPECT_THAT(appended.message, HasSubstr("1 points without finite position"));
  }
  ExpectSameCloud(read, expected);
}

TEST_F(FusedCloudTest, BytesAreColmaps) {
  VisibilityCloud cloud;
  const std::vector<uint32_t> views = {1, 4};
  cloud.Add({1, 2, 3}, {0, 0, 1}, {7, 8, 9}, views);
  WriteFusedCloud(path_, cloud, data_.scene);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  const std::string ply = ReadWholeFile(path_);
  EXPECT_EQ(ply.substr(0, header.size()), header);
  EXPECT_EQ(ply.size(), header.size() + 27);
  EXPECT_EQ(ReadWholeFile(vis_path_), std::string("\1\0\0\0\0\0\0\0\2\0\0\0\1\0\0\0\4\0\0\0", 20));
}

TEST_F(FusedCloudTest, PartsMakeTheCloud) {
  WriteFusedCloud(path_, cloud_, data_.scene);
  const std::string ply = ReadWholeFile(path_), vis = ReadWholeFile(vis_path_);
  {
    FusedCloudWriter writer(path_, data_.scene, cloud_.size());
    for (size_t p = 0; p < cloud_.size(); ++p) {
      VisibilityCloud part;
      part.Add(cloud_.positions[p], cloud_.normals[p], cloud_.colors[p], cloud_.ViewsOf(p));
      writer.Add(part);
      writer.Add({});
    }
    EXPECT_EQ(ReadWholeFile(path_), ply);  // of before
    std::filesystem::remove(vis_path_);
    writer.Commit();
  }
  EXPECT_EQ(ReadWholeFile(path_), ply);
  EXPECT_EQ(ReadWholeFile(vis_path_), vis);
  { FusedCloudWriter(path_, data_.scene).Add(cloud_); }
  EXPECT_EQ(ReadWholeFile(path_), ply);
}

// Only a comment in the header tells a cloud whose size was not known beforehand.
TEST_F(FusedCloudTest, NumberOfPointsMayBeUnknownBeforehand) {
  WriteFusedCloud(path_, cloud_, data_.scene);
  const std::string ply = ReadWholeFile(path_), vis = ReadWholeFile(vis_path_);
  FusedCloudWriter writer(path_, data_.scene);
  writer.Add(cloud_);
  writer.Commit();
  std::string padded = ReadWholeFile(path_);
  const size_t begin = padded.find("comment"), end = padded.find("element");
  ASSERT_LT(begin, end);
  EXPECT_EQ(padded.erase(begin, end - begin), ply);
  EXPECT_EQ(ReadWholeFile(vis_path_), vis);
  ExpectSameCloud(Read().cloud, cloud_);
}

TEST_F(FusedCloudTest, VisibilityOfAMeshIsReadAsThatOfACloud) {
  WriteFusedCloud(path_, cloud_, data_.scene);
  std::filesystem::remove(vis_path_);
  WriteVisibility(vis_path_, cloud_.view_begin, cloud_.view_idxs);
  ExpectSameCloud(Read().cloud, cloud_);
  WriteVisibility(vis_path_, {0}, {});
  EXPECT_EQ(ReadWholeFile(vis_path_), std::string(8, '\0'));
}

TEST_F(FusedCloudTest, EmptyCloudIsLegal) {
  WriteFusedCloud(path_, {}, data_.scene);
  EXPECT_EQ(Read().cloud.size(), 0u);
}

TEST_F(FusedCloudTest, LargeCoordinatesAreKeptAsDoubles) {
  Scene scene = data_.scene;
  scene.world_offset = {500000, 5400000, 0};
  WriteFusedCloud(path_, cloud_, scene);
  EXPECT_THAT(ReadWholeFile(path_), HasSubstr("property double x"));
  ExpectSameCloud(ReadFusedCloud(path_, scene, data_.workspace).cloud, cloud_);
}

TEST_F(FusedCloudTest, OtherDialectsAreRead) {
  const std::vector<uint32_t> views = {0};
  VisibilityCloud cloud;
  const Eigen::Vector3f x = cloud_.positions[0];
  cloud.Add(x, Eigen::Vector3f(0, 0, 1), Color(1, 2, 3), views);
  WriteFusedCloud(path_, cloud, data_.scene);
  WriteWholeFile(path_,
                 fmt::format("ply\r\nformat ascii 1.0\r\ncomment edited\r\n"
                             "element vertex 1\r\nproperty uchar blue\r\nproperty double z\r\n"
                             "property float quality\r\nproperty double y\r\n"
                             "property uchar green\r\nproperty double x\r\n"
                             "property uchar red\r\nproperty uchar alpha\r\n"
                             "element face 0\r\nproperty list uchar int vertex_indices\r\n"
                             "end_header\r\n3 {} 0.5 {} 2 {} 1 255\r\n",
                             x.z(), x.y(), x.x()));
  const FusedCloud read = Read();
  EXPECT_EQ(read.cloud.positions[0], x);
  EXPECT_TRUE(read.cloud.normals[0].isZero());
  EXPECT_EQ(read.cloud.colors[0], Color(1, 2, 3));
}

TEST_F(FusedCloudTest, PointsThatAreNotFiniteAreLeftOut) {
  cloud_.positions[3].y() = std::nanf("");
  WriteFusedCloud(path_, cloud_, data_.scene);
  const FusedCloud read = Read();
  EXPECT_EQ(read.num_dropped, 1u);
  EXPECT_THAT(read.message, HasSubstr("1 points without finite position"));
  ASSERT_EQ(read.cloud.size(), cloud_.size() - 1);
  EXPECT_EQ(read.cloud.positions[3], cloud_.positions[4]);
  EXPECT_EQ(read.cloud.ViewsOf(3).size(), cloud_.ViewsOf(4).size());
}

TEST_F(FusedCloudTest, CroppedCloudIsRefusedWithRemedy) {
  WriteFusedCloud(path_, cloud_, data_.scene);
  const std::string vis = ReadWholeFile(vis_path_);
  VisibilityCloud cropped;
  for (size_t p = 0; p < 10; ++p) {
    cropped.Add(cloud_.positions[p], cloud_.normals[p], cloud_.colors[p], cloud_.ViewsOf(p));
  }
  WriteFusedCloud(path_, cropped, data_.scene);
  WriteWholeFile(vis_path_, vis);
  EXPECT_THAT(Error(), HasSubstr(fmt::format(
                           "fused.ply.vis: is for {} points, but fused.ply has 10: the cloud was "
                           "cropped or edited; crop with a tool that keeps both, or remove both",
                           cloud_.size())));
}

TEST_F(FusedCloudTest, MissingFilesAreNamed) {
  EXPECT_THAT(Error(), HasSubstr("fused.ply"));
  WriteFusedCloud(path_, cloud_, data_.scene);
  std::filesystem::remove(vis_path_);
  EXPECT_THAT(Error(), HasSubstr("fused.ply.vis: is missing"));
}

TEST_F(FusedCloudTest, TruncationAndMutationAreSurvived) {
  VisibilityCloud small;
  for (size_t p = 0; p < 3; ++p) {
    small.Add(cloud_.positions[p], cloud_.normals[p], cloud_.colors[p], cloud_.ViewsOf(p));
  }
  WriteFusedCloud(path_, small, data_.scene);
  ExpectErrorAtEveryTruncation(vis_path_, [&] { Read(); });
  ExpectErrorAtEveryTruncation(path_, [&] { Read(); });
  ExpectSurvivesMutations(vis_path_, 300, [&] { Read(); });
  ExpectSurvivesMutations(path_, 300, [&] { Read(); });
}

TEST_F(FusedCloudTest, IndexBeyondTheImagesIsAnError) {
  WriteFusedCloud(path_, cloud_, data_.scene);
  std::string vis = ReadWholeFile(vis_path_);
  vis[12] = 6;
  WriteWholeFile(vis_path_, vis);
  EXPECT_THAT(Error(), HasSubstr("names image 6, but the sparse model has 6 images (at byte 12)"));
}

// Writes the cloud with the views numbered by their place in `order`.
void WriteInOrder(const std::filesystem::path& path, const VisibilityCloud& cloud,
                  const Scene& scene, const std::vector<uint32_t>& order) {
  VisibilityCloud renumbered;
  for (size_t p = 0; p < cloud.size(); ++p) {
    std::vector<uint32_t> views;
    for (const uint32_t view : cloud.ViewsOf(p)) {
      const auto place = std::find(order.begin(), order.end(), view);
      views.push_back(static_cast<uint32_t>(place - order.begin()));
    }
    renumbered.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], views);
  }
  WriteFusedCloud(path, renumbered, scene);
}

std::vector<uint32_t> SortedViews(const Scene& scene, bool by_name) {
  std::vector<uint32_t> order;
  for (uint32_t v = 0; v < scene.views.size(); ++v) order.push_back(v);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return by_name ? scene.views[a].name < scene.views[b].name
                   : scene.views[a].image_id < scene.views[b].image_id;
  });
  return order;
}

TEST(ImageOrderTest, OtherOrderIsFoundAndReported) {
  LSMVS_REQUIRE_SCENE("syn-igea");
  const DenseWorkspace workspace{TestDataFolder() / "syn-igea"};
  const Scene scene = LoadScene(workspace, {.check_images = false});
  // Sparse points have no normals; the direction to the first view that sees them will do.
  VisibilityCloud cloud;
  for (const SparsePoint& point : scene.points) {
    const std::vector<uint32_t> views(point.view_idxs.begin(), point.view_idxs.end());
    const Eigen::Vector3d normal =
        (scene.views[views[0]].CenterInWorld() - point.x_in_world).normalized();
    cloud.Add(point.x_in_world.cast<float>(), normal.cast<float>(), point.color, views);
  }
  const TemporaryFolder folder;
  const auto path = folder.path() / "fused.ply";
  for (const bool by_name : {false, true}) {
    const std::vector<uint32_t> order = SortedViews(scene, by_name);
    if (std::is_sorted(order.begin(), order.end())) continue;
    WriteInOrder(path, cloud, scene, order);
    const FusedCloud read = ReadFusedCloud(path, scene, workspace);
    EXPECT_THAT(read.message, HasSubstr("the images of the visibility file are in"));
    ExpectSameCloud(read.cloud, cloud);
  }
}

TEST_F(FusedCloudTest, CloudOfAnotherModelIsRefused) {
  for (Eigen::Vector3f& x : cloud_.positions) x += Eigen::Vector3f(100, 0, 0);
  WriteFusedCloud(path_, cloud_, data_.scene);
  EXPECT_THAT(Error(), HasSubstr("does not fit the sparse model: only 0 % of the points"));
}

TEST_F(FusedCloudTest, ViewThatIsNotThereIsAProgrammersError) {
  const std::vector<uint32_t> views = {6};
  cloud_.Add({0, 0, 0}, {0, 0, 1}, {0, 0, 0}, views);
  EXPECT_THROW(WriteFusedCloud(path_, cloud_, data_.scene), std::logic_error);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST(FusedCloudRealTest, ColmapsOwnFilesKeepTheirBytes) {
  LSMVS_REQUIRE_SCENE("fountain-P11-fused");
  const DenseWorkspace workspace{TestDataFolder() / "fountain-P11-fused"};
  const Scene scene = LoadScene(workspace);
  const FusedCloud read = ReadFusedCloud(workspace.FusedPath(), scene, workspace);
  EXPECT_EQ(read.message, "");
  EXPECT_EQ(read.cloud.size(), 1000000u);
  const TemporaryFolder folder;
  WriteFusedCloud(folder.path() / "fused.ply", read.cloud, scene);
  EXPECT_TRUE(ReadWholeFile(workspace.FusedPath()) == ReadWholeFile(folder.path() / "fused.ply"));
  EXPECT_TRUE(ReadWholeFile(workspace.folder / "fused.ply.vis") ==
              ReadWholeFile(folder.path() / "fused.ply.vis"));
}

VisibilityCloud SomePoints(const VisibilityCloud& cloud, size_t begin, size_t end) {
  VisibilityCloud part;
  for (size_t p = begin; p < end; ++p) {
    part.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], cloud.ViewsOf(p));
  }
  return part;
}

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Writes the cloud in parts (one of them empty), and what AddFile() makes of these.
class JoinedFiles : public FusedCloudTest {
 protected:
  std::vector<std::filesystem::path> WriteParts() const {
    const size_t num_points = cloud_.size();
    const std::vector<size_t> begins = {0, num_points / 3, num_points / 3, num_points};
    std::vector<std::filesystem::path> paths;
    for (size_t i = 0; i + 1 < begins.size(); ++i) {
      paths.push_back(folder_.path() / fmt::format("part{}.ply", i));
      FusedCloudWriter writer(paths.back(), data_.scene);
      writer.Add(SomePoints(cloud_, begins[i], begins[i + 1]));
      writer.Commit();
    }
    return paths;
  }
  void WriteJoined(const std::vector<std::filesystem::path>& parts) const {
    FusedCloudWriter writer(path_, data_.scene);
    for (const std::filesystem::path& part : parts) writer.AddFile(part);
    writer.Commit();
    EXPECT_EQ(writer.size().num_points, cloud_.size());
    EXPECT_EQ(writer.size().num_view_entries, cloud_.view_idxs.size());
  }
};

TEST_F(JoinedFiles, HaveTheBytesOfOneCloud) {
  for (const Eigen::Vector3d& offset : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(5e5, 4e6, 10)}) {
    data_.scene.world_offset = offset;
    const auto whole = folder_.path() / "whole.ply";
    FusedCloudWriter writer(whole, data_.scene);
    writer.Add(cloud_);
    writer.Commit();
    WriteJoined(WriteParts());
    EXPECT_EQ(ReadBytes(path_), ReadBytes(whole));
    EXPECT_EQ(ReadBytes(vis_path_), ReadBytes(DenseWorkspace::VisibilityPath(whole)));
  }
}

TEST_F(JoinedFiles, ThatAreCutOffAreRefused) {
  const auto parts = WriteParts();
  std::filesystem::resize_file(parts.back(), std::filesystem::file_size(parts.back()) - 1);
  EXPECT_THROW(WriteJoined(parts), InputError);
}

TEST_F(JoinedFiles, WhoseVisibilityIsForOtherPointsAreRefused) {
  const auto parts = WriteParts();
  std::filesystem::copy_file(DenseWorkspace::VisibilityPath(parts.front()),
                             DenseWorkspace::VisibilityPath(parts.back()),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(WriteJoined(parts), InputError);
}

}  // namespace
}  // namespace lsmvs
