#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "program_runner.h"
#include "small_workspace.h"

// Fusion in parts, of more photos than one task of it takes.

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// Eighteen photos with their depth maps.
class FusionParts : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder();
    SyntheticSceneOptions options;
    options.shape = ShapeName::kRelief;
    options.num_views = 18;
    options.width = 96;
    options.height = 72;
    options.num_sparse_points = 500;
    SyntheticScene scene = MakeScene(options, RunContext(1));
    WriteWorkspace(Workspace(), WorkspaceFormat::kDense, &scene, RunContext(1));
    ExpectSuccess(RunProgram("lsmvs-mesher", {Workspace().string(), "--to", "stereo_fusion"}));
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Workspace() { return folder_->path() / "w"; }
  static fs::path CopyWorkspace(const TemporaryFolder& to) {
    fs::copy(Workspace(), to.path() / "w", fs::copy_options::recursive);
    return to.path() / "w";
  }
  static std::string Cloud(const fs::path& workspace) {
    return ReadText(workspace / "fused.ply") + ReadText(workspace / "fused.ply.vis");
  }
  static size_t NumParts(const fs::path& workspace) {
    size_t count = 0;
    for (const auto& entry : fs::directory_iterator(workspace / "lsmvs")) {
      count += entry.path().filename().string().find("part") != std::string::npos;
    }
    return count;
  }

  static TemporaryFolder* folder_;
};

TemporaryFolder* FusionParts::folder_ = nullptr;

TEST_F(FusionParts, AreGoneInTheEndAndNotMissed) {
  EXPECT_GT(Cloud(Workspace()).size(), 100000u);
  EXPECT_EQ(NumParts(Workspace()), 0u);
  const ProgramResult again =
      RunProgram("lsmvs-mesher", {Workspace().string(), "--to", "stereo_fusion"});
  ExpectSuccess(again);
  EXPECT_THAT(again.out, HasSubstr("everything is up to date"));
}

TEST_F(FusionParts, AreOneAfterTheOtherWhereThereAreJobs) {
  const TemporaryFolder folder;
  const fs::path workspace = CopyWorkspace(folder);
  fs::remove(workspace / "fused.ply");
  fs::remove(workspace / "fused.ply.vis");
  const ProgramResult result = RunProgram(
      "lsmvs-mesher", {workspace.string(), "--to", "stereo_fusion", "--engine", "command",
                       "--submit_command", "sh {commands}", "--job_minutes", "0"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, Not(HasSubstr("not divided")));
  EXPECT_EQ(Cloud(workspace), Cloud(Workspace()));
  EXPECT_EQ(NumParts(workspace), 0u);
}

TEST_F(FusionParts, OfACloudElsewhereGiveTheSame) {
  const TemporaryFolder folder;
  const fs::path workspace = CopyWorkspace(folder);
  const fs::path elsewhere = folder.path() / "fused.ply";
  ExpectSuccess(RunProgram("lsmvs", {"stereo_fusion", "--workspace_path", workspace.string(),
                                     "--output_path", elsewhere.string()}));
  EXPECT_EQ(ReadText(elsewhere), ReadText(Workspace() / "fused.ply"));
  EXPECT_EQ(Cloud(workspace), Cloud(Workspace()));
  const ProgramResult again =
      RunProgram("lsmvs-mesher", {workspace.string(), "--to", "stereo_fusion"});
  EXPECT_THAT(again.out, HasSubstr("everything is up to date"));
}

TEST_F(FusionParts, AreAllMadeAnewWhereAnOptionOfFusionChanges) {
  const TemporaryFolder folder;
  const fs::path workspace = CopyWorkspace(folder);
  const ProgramResult result = RunProgram(
      "lsmvs-mesher",
      {workspace.string(), "--to", "stereo_fusion", "--StereoFusion.min_num_pixels", "4"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, HasSubstr("3 steps, options changed"));
  EXPECT_LT(Cloud(workspace).size(), Cloud(Workspace()).size());
}

}  // namespace
}  // namespace lsmvs
