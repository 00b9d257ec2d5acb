#include "lsmvs/synthetic/workspace.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"

namespace lsmvs {
namespace {

TEST(Workspace, DenseWorkspaceLoadsAsTheSceneThatItWasMadeFrom) {
  SyntheticScene s = MakeScene(ShapeName::kStep, 6, 64, 48);
  const TemporaryFolder folder;
  WriteWorkspace(folder.path(), WorkspaceFormat::kDense, &s, RunContext());
  EXPECT_TRUE(IsDenseWorkspace(folder.path()));
  const Scene loaded = LoadScene(DenseWorkspace{folder.path()});
  ASSERT_EQ(loaded.num_views(), 6);
  for (int v = 0; v < 6; ++v) {
    const View& expected = s.scene.views[v];
    EXPECT_EQ(loaded.views[v].name, expected.name);
    EXPECT_DOUBLE_EQ(loaded.views[v].camera.fx, expected.camera.fx);
    EXPECT_LT((loaded.views[v].CenterInWorld() - expected.CenterInWorld()).norm(), 1e-12);
  }
  ASSERT_EQ(loaded.points.size(), s.scene.points.size());
  EXPECT_EQ(loaded.points[7].view_idxs, s.scene.points[7].view_idxs);
  EXPECT_LT((loaded.points[7].x_in_world - s.scene.points[7].x_in_world).norm(), 1e-12);
}

TEST(Workspace, ProjectAndPhotosHoldWhatTheyShould) {
  SyntheticScene s = MakeScene(ShapeName::kBox, 4, 32, 24);
  const TemporaryFolder folder;
  WriteWorkspace(folder.path() / "a", WorkspaceFormat::kProject, &s, RunContext());
  EXPECT_TRUE(IsSparseModelFolder(folder.path() / "a/sparse/0"));
  EXPECT_FALSE(IsDenseWorkspace(folder.path() / "a"));
  WriteWorkspace(folder.path() / "b", WorkspaceFormat::kPhotos, &s, RunContext());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "b/sparse"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "b/images/0003.png"));
}

TEST(Workspace, TruthMeshIsTheVisibleSurface) {
  for (const ShapeName name : {ShapeName::kSphereOnGround, ShapeName::kPole}) {
    const SyntheticScene s = MakeScene(name, 8, 160, 120);
    const TriangleMesh mesh = TruthMesh(s);
    EXPECT_LT(MeasureAccuracy(mesh, s, 0, 3000).max, 0.2 * s.gsd);
    EXPECT_LT(MeasureCompleteness(mesh, s, 2, 3000).p95, 0.15 * s.gsd);
    EXPECT_LT(mesh.faces.size(), s.shape->Mesh(6 * s.gsd).faces.size());
  }
}

TEST(Workspace, CameraCentersAreWrittenByName) {
  const SyntheticScene s = MakeScene(ShapeName::kBox, 4, 32, 24);
  const TemporaryFolder folder;
  WriteTruth(folder.path(), s);
  std::ifstream file(folder.path() / "camera_centers.txt");
  std::string name;
  Eigen::Vector3d c;
  int count = 0;
  while (file >> name >> c.x() >> c.y() >> c.z()) {
    EXPECT_EQ(name, s.scene.views[count].name);
    EXPECT_LT((c - s.scene.views[count].CenterInWorld()).norm(), 1e-12);
    ++count;
  }
  EXPECT_EQ(count, 4);
}

class Program : public ::testing::Test {
 protected:
  int Run(const std::string& arguments) const {
    const std::string command = (ProgramFolder() / "make_synthetic_workspace").string() + " " +
                                arguments + " > " + (folder_.path() / "log").string() + " 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string Log() const {
    std::ifstream file(folder_.path() / "log");
    return {std::istreambuf_iterator<char>(file), {}};
  }
  TemporaryFolder folder_;
};

TEST_F(Program, WritesAWorkspace) {
  const std::string output = (folder_.path() / "w").string();
  EXPECT_EQ(Run("--output " + output + " --shape torus --num_views 3 --width 32 --height 24"), 0)
      << Log();
  EXPECT_EQ(LoadScene(DenseWorkspace{output}).num_views(), 3);
  EXPECT_TRUE(Inspect(ReadMeshPly(output + "/gt_mesh.ply")).IsClosed());
}

TEST_F(Program, ReplacesAFilledFolderOnlyIfTold) {
  const std::string output = (folder_.path() / "w").string();
  const std::string arguments =
      "--output " + output + " --format photos --num_views 2 --width 16 --height 16";
  ASSERT_EQ(Run(arguments), 0) << Log();
  std::ofstream(output + "/gt_mesh.ply") << "mine";
  EXPECT_EQ(Run(arguments), 6);
  EXPECT_NE(Log().find("--overwrite"), std::string::npos) << Log();
  EXPECT_EQ(std::filesystem::file_size(output + "/gt_mesh.ply"), 4u);
  EXPECT_EQ(Run(arguments + " --overwrite 1"), 0) << Log();
  EXPECT_GT(std::filesystem::file_size(output + "/gt_mesh.ply"), 4u);
}

TEST_F(Program, RefusesWhatMakesNoSense) {
  EXPECT_EQ(Run("--shape torus"), 2);
  EXPECT_NE(Log().find("--output"), std::string::npos);
  EXPECT_EQ(Run("--output x --shape cube"), 2);
  EXPECT_NE(Log().find("cube"), std::string::npos);
  EXPECT_EQ(Run("--output x --num_views 0"), 2);
  EXPECT_EQ(Run("--nonsense 1"), 2);
  EXPECT_EQ(Run("--output"), 2);
  EXPECT_EQ(Run("--help"), 0);
  EXPECT_NE(Log().find("--num_views"), std::string::npos);
}

}  // namespace
}  // namespace lsmvs
