#include "lsmvs/colmap_adapter/dense_workspace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/adapter_test/small_model.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class DenseWorkspaceTest : public testing::Test {
 protected:
  void MakeModel(const fs::path& folder, SparseFormat format = SparseFormat::kBinary) const {
    WriteSparseModel(root_ / folder, SmallModel(false), format);
  }
  void MakeFile(const fs::path& path) const {
    fs::create_directories((root_ / path).parent_path());
    WriteWholeFile(root_ / path, "x");
  }
  // What image_undistorter leaves.
  void MakeWorkspace(const fs::path& folder) const {
    MakeModel(folder / "sparse");
    MakeFile(folder / "images/a.jpg");
    MakeFile(folder / "stereo/fusion.cfg");
  }
  std::string Error(const fs::path& path) const {
    return InputErrorOf([&] { FindDenseWorkspaces(root_ / path); });
  }

  TemporaryFolder folder_;
  const fs::path root_ = folder_.path();
};

TEST_F(DenseWorkspaceTest, NamesAreColmaps) {
  const DenseWorkspace workspace{"/w"};
  EXPECT_EQ(workspace.DepthMapPath("sub/a.jpg", DepthMapKind::kPhotometric),
            "/w/stereo/depth_maps/sub/a.jpg.photometric.bin");
  EXPECT_EQ(workspace.NormalMapPath("a.jpg", DepthMapKind::kGeometric),
            "/w/stereo/normal_maps/a.jpg.geometric.bin");
  EXPECT_EQ(DenseWorkspace::VisibilityPath(workspace.FusedPath()), "/w/fused.ply.vis");
}

TEST_F(DenseWorkspaceTest, DenseWorkspaceIsItself) {
  MakeWorkspace("");
  const auto found = FindDenseWorkspaces(root_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].exists);
  EXPECT_EQ(found[0].workspace.folder, root_);
  EXPECT_EQ(found[0].workspace.SparseFolder(), root_ / "sparse");
}

TEST_F(DenseWorkspaceTest, ModelMayLieInSparse0) {
  MakeModel("sparse/0", SparseFormat::kText);
  MakeFile("images/a.jpg");
  EXPECT_FALSE(IsDenseWorkspace(root_));
  MakeFile("stereo/fusion.cfg");
  EXPECT_TRUE(IsDenseWorkspace(root_));
  EXPECT_EQ(DenseWorkspace{root_}.SparseFolder(), root_ / "sparse/0");
}

TEST_F(DenseWorkspaceTest, FusedCloudIsASignOfDenseWork) {
  MakeModel("sparse");
  MakeFile("images/a.jpg");
  EXPECT_FALSE(IsDenseWorkspace(root_));
  MakeFile("fused.ply");
  EXPECT_TRUE(IsDenseWorkspace(root_));
}

TEST_F(DenseWorkspaceTest, EveryModelOfAProjectGetsAWorkspace) {
  MakeModel("sparse/0");
  MakeModel("sparse/2");
  MakeModel("sparse/10");
  MakeFile("sparse/3/readme");
  MakeFile("images/a.jpg");
  MakeWorkspace("dense/2");
  const auto found = FindDenseWorkspaces(root_);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_FALSE(found[0].exists);
  EXPECT_EQ(found[0].workspace.folder, root_ / "dense/0");
  EXPECT_EQ(found[0].sparse_folder, root_ / "sparse/0");
  EXPECT_EQ(found[0].image_folder, root_ / "images");
  EXPECT_TRUE(found[1].exists);
  EXPECT_EQ(found[1].workspace.folder, root_ / "dense/2");
  EXPECT_EQ(found[2].workspace.folder, root_ / "dense/10");
}

TEST_F(DenseWorkspaceTest, ModelDirectlyInSparseIsAProject) {
  MakeModel("sparse");
  MakeFile("images/a.jpg");
  const auto found = FindDenseWorkspaces(root_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].exists);
  EXPECT_EQ(found[0].sparse_folder, root_ / "sparse");
  EXPECT_EQ(found[0].workspace.folder, root_ / "dense/0");
}

TEST_F(DenseWorkspaceTest, AutomaticReconstructorsFolder) {
  // The photos lie elsewhere; that matters only for models that are not undistorted yet.
  MakeModel("sparse/0");
  MakeWorkspace("dense/0");
  EXPECT_TRUE(FindDenseWorkspaces(root_).at(0).exists);
  MakeModel("sparse/1");
  EXPECT_THAT(Error(""), HasSubstr("images: the folder of the photos is missing; name the photos' "
                                   "folder with --image_path"));
  MakeFile("photos/a.jpg");
  const auto found = FindDenseWorkspaces(root_, root_ / "photos");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[1].image_folder, root_ / "photos");
}

TEST_F(DenseWorkspaceTest, DenseWithoutSparseIsEnough) {
  MakeWorkspace("dense/0");
  MakeWorkspace("dense/1");
  EXPECT_EQ(FindDenseWorkspaces(root_).size(), 2u);
  EXPECT_EQ(FindDenseWorkspaces(root_ / "dense").size(), 2u);
}

TEST_F(DenseWorkspaceTest, DenseFolderThatIsAWorkspace) {
  MakeModel("sparse/0");
  MakeFile("images/a.jpg");
  MakeWorkspace("dense");
  const auto found = FindDenseWorkspaces(root_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].workspace.folder, root_ / "dense");
}

TEST_F(DenseWorkspaceTest, HalfAWorkspaceIsInTheWay) {
  MakeModel("sparse/0");
  MakeFile("images/a.jpg");
  fs::create_directories(root_ / "dense/0");
  EXPECT_FALSE(FindDenseWorkspaces(root_).at(0).exists);
  MakeFile("dense/0/images/a.jpg");
  EXPECT_THAT(Error(""), HasSubstr("dense/0: is not a complete dense workspace"));
}

TEST_F(DenseWorkspaceTest, ErrorsSayWhatIsMissing) {
  EXPECT_THAT(Error("nothing"), HasSubstr("nothing: does not exist"));
  EXPECT_THAT(Error(""), HasSubstr("is neither a dense workspace"));
  MakeFile("file");
  EXPECT_THAT(Error("file"), HasSubstr("file: is not a folder"));
  MakeModel("model");
  EXPECT_THAT(Error("model"), HasSubstr("is a sparse model, not a workspace"));
  fs::create_directory(root_ / "sparse");
  EXPECT_THAT(Error(""), HasSubstr("sparse: holds no sparse model"));
  MakeModel("sparse/0");
  EXPECT_THAT(Error(""), HasSubstr("images: the folder of the photos is missing"));
  fs::create_directory(root_ / "images");
  EXPECT_THAT(Error(""), HasSubstr("images: the folder of the photos is empty"));
}

}  // namespace
}  // namespace lsmvs
