#include "lsmvs/colmap_adapter/pmvs_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "lsmvs/colmap_adapter/pmvs_scene.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// As pmvs2 writes it: blanks at the ends of lists, an empty line after each patch, no line of
// numbers for an empty list.
constexpr const char* kTwoPatches =
    "PATCHES\n2\n"
    "PATCHS\n1.5 -2 3e-1 1\n0 0 -1 0\n0.875 0.01 0.02\n3\n0 2 1 \n1\n3 \n\n"
    "PATCHS\n4 5 6 1\n1 0 0 0\n0.75 0.01 0.02\n2\n1 3 \n0\n\n\n";

constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\n"
    "end_header\n1 2 3 0 0 -1 10 20 30\n4 5 6 0 1 0 255 0 1\n";

class Pmvs : public testing::Test {
 protected:
  fs::path Write(const fs::path& name, const std::string& text) {
    fs::create_directories((folder_.path() / name).parent_path());
    WriteFileAtomically(folder_.path() / name, text);
    return folder_.path() / name;
  }
  // A folder with `num_photos` matrices and without results.
  fs::path Folder(int num_photos) {
    for (int i = 0; i < num_photos; ++i) {
      Write("pmvs/txt/0000000" + std::to_string(i) + ".txt",
            "CONTOUR\n1 0 0 0\n0 1 0 0\n0 0 1 0\n");
    }
    fs::create_directories(folder_.path() / "pmvs" / "visualize");
    return folder_.path() / "pmvs";
  }
  void ExpectRefused(const fs::path& path, const std::string& what) {
    try {
      ReadPmvsCloud(path);
      ADD_FAILURE() << "not refused: " << what;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
      EXPECT_THAT(error.what(), HasSubstr(folder_.path().string()));
    }
  }

  TemporaryFolder folder_;
};

TEST_F(Pmvs, PatchesAreRead) {
  const fs::path path = Write("a.patch", kTwoPatches);
  EXPECT_TRUE(IsPmvsResult(path));
  EXPECT_EQ(CountPmvsPoints(path), 2u);
  const PmvsCloud cloud = ReadPmvsCloud(path, {1, 1, 1});
  ASSERT_EQ(cloud.points.vertices.size(), 2u);
  EXPECT_EQ(cloud.points.vertices[0], Eigen::Vector3d(0.5, -3, -0.7));
  EXPECT_EQ(cloud.points.vertex_normals[1], Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(cloud.scores, (std::vector<float>{0.875f, 0.75f}));
  EXPECT_EQ(cloud.num_views, (std::vector<int>{3, 2}));
  EXPECT_TRUE(cloud.points.faces.empty());
}

TEST_F(Pmvs, PatchesWithDirectionsAreRead) {
  const fs::path path =
      Write("a.patch", "PATCHES\n1\nPATCHA\n1 2 3 1\n0 0 1 0\n0.9 1 1\n2\n0 0 1 0\n2\n0 1\n1\n2\n");
  EXPECT_EQ(ReadPmvsCloud(path).num_views, std::vector<int>{2});
}

TEST_F(Pmvs, PointsOfPlyHaveColors) {
  Folder(1);
  Write("pmvs/models/option-all.ply", kPly);
  const PmvsCloud cloud = ReadPmvsCloud(folder_.path() / "pmvs");
  ASSERT_EQ(cloud.points.vertices.size(), 2u);
  EXPECT_EQ(cloud.points.vertex_colors[0], (Eigen::Matrix<uint8_t, 3, 1>(10, 20, 30)));
  EXPECT_EQ(cloud.points.vertex_normals[1], Eigen::Vector3f(0, 1, 0));
  EXPECT_TRUE(cloud.scores.empty());
  EXPECT_TRUE(cloud.num_views.empty());
}

TEST_F(Pmvs, EveryCutOfAFileIsRefused) {
  const std::string text = kTwoPatches;
  // Up to the 0 that ends the last patch.
  const size_t end = text.rfind('0');
  for (size_t length = 0; length < end; ++length) {
    const fs::path path = Write("cut.patch", text.substr(0, length));
    EXPECT_THROW(ReadPmvsCloud(path), InputError) << length;
  }
  EXPECT_EQ(ReadPmvsCloud(Write("cut.patch", text.substr(0, end + 1))).scores.size(), 2u);
}

TEST_F(Pmvs, BadPatchesAreRefused) {
  const std::string text = kTwoPatches;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    return Write("bad.patch", changed);
  };
  ExpectRefused(with("PATCHES", "PATCHS"), "line 1: does not begin with PATCHES");
  ExpectRefused(with("\n2\n", "\n3\n"), "ends before the start of patch 3 of 3");
  ExpectRefused(with("\n2\n", "\n1\n"), "line 12: goes on after the 1 patches");
  ExpectRefused(with("\n2\n", "\n-2\n"), "line 2: has '-2'");
  ExpectRefused(with("1.5", "nan"), "line 4: has a number that is not finite");
  ExpectRefused(with("-1 0", "inf 0"), "line 5: has a number that is not finite");
  ExpectRefused(with("0.875", "nan"), "line 6: has a number that is not finite");
  ExpectRefused(with("3e-1 1", "3e-1 2"), "fourth coordinate");
  ExpectRefused(with("0 2 1 ", "0 2 "), "line 8: ends too early");
  ExpectRefused(with("0 2 1 ", "0 2 1 1"), "line 8: has '1' where it should end");
  ExpectRefused(with("0 2 1 ", "0 -2 1 "), "line 8: has '-2'");
  ExpectRefused(with("PATCHS\n4", "PATCH\n4"), "where PATCHS should begin patch 2 of 2");
  ExpectRefused(folder_.path() / "none.patch", "cannot be opened");
}

TEST_F(Pmvs, FolderNamesItsResults) {
  EXPECT_FALSE(IsPmvsFolder(folder_.path() / "pmvs"));
  const fs::path pmvs = Folder(4);
  EXPECT_TRUE(IsPmvsFolder(pmvs));
  EXPECT_FALSE(HasPmvsFiles(pmvs));
  ExpectRefused(pmvs, "holds no points of PMVS");
  const fs::path ply = Write("pmvs/models/option-all.ply", kPly);
  EXPECT_EQ(PmvsFiles(pmvs), std::vector<fs::path>{ply});
  // Patches tell more than the .ply beside them.
  const fs::path patches = Write("pmvs/models/option-all.patch", kTwoPatches);
  EXPECT_EQ(PmvsFiles(pmvs), std::vector<fs::path>{patches});
  Write("pmvs/models/option-0000.patch", kTwoPatches);
  ExpectRefused(pmvs, "holds several results");
  fs::remove(patches);
  Write("pmvs/models/option-0001.patch", kTwoPatches);
  EXPECT_EQ(ReadPmvsCloud(pmvs).points.vertices.size(), 4u);
  EXPECT_EQ(CountPmvsPoints(pmvs), 4u);
}

TEST_F(Pmvs, PhotosMustBeThere) {
  const fs::path pmvs = Folder(3);
  Write("pmvs/models/option-all.patch", kTwoPatches);
  ExpectRefused(pmvs, "line 10: has '3'");  // photo 3, where 0, 1 and 2 are there
  fs::remove(pmvs / "txt" / "00000001.txt");
  ExpectRefused(pmvs, "00000001.txt: is missing");
}

}  // namespace
}  // namespace lsmvs
