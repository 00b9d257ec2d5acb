#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/mesh/ply.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

TEST(Resume, ASecondRunDoesNothing) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
  const auto before = ReadResults(workspace.path());
  const ProgramResult again = RunProgram("lsmvs-mesher", {workspace.text()});
  ExpectSuccess(again);
  EXPECT_THAT(again.out, HasSubstr("everything is up to date"));
  EXPECT_EQ(ReadResults(workspace.path()), before);
  for (const char* mesh : {"meshed-visibility.ply", "meshed-refined.ply"}) {
    EXPECT_GT(ReadMeshPly(workspace / mesh).faces.size(), 100u);
  }
  EXPECT_FALSE(ReadMeshPly(workspace / "meshed-refined.ply").vertex_colors.empty());
}

TEST(Resume, ChangedOptionRunsItsStageAndTheLaterOnes) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "visibility_mesher"}));
  EXPECT_FALSE(fs::exists(workspace / "meshed-refined.ply"));
  const ProgramResult again =
      RunProgram("lsmvs-mesher", {workspace.text(), "--to", "visibility_mesher",
                                  "--VisibilityMeshing.smoothing_iterations", "5"});
  ExpectSuccess(again);
  EXPECT_THAT(again.err, HasSubstr("visibility_mesher: done"));
  EXPECT_THAT(again.err, Not(HasSubstr("patch_match_stereo: started")));
  EXPECT_THAT(again.out, HasSubstr("options changed"));
}

TEST(Resume, TheStagesAsCommandsGiveTheBytesOfTheWholeRun) {
  const SmallWorkspace whole, staged;
  // The command for stereo alone keeps all maps.
  ExpectSuccess(RunProgram("lsmvs-mesher",
                           {whole.text(), "--quality", "extreme", "--keep_photometric_maps", "1"}));
  const std::string w = staged.text();
  ExpectSuccess(RunProgram(
      "lsmvs", {"patch_match_stereo", "--workspace_path", w, "--workspace_format", "COLMAP"}));
  ExpectSuccess(RunProgram("lsmvs", {"stereo_fusion", "--workspace_path", w, "--input_type",
                                     "geometric", "--output_path", w + "/fused.ply"}));
  ExpectSuccess(RunProgram("lsmvs", {"visibility_mesher", "--input_path", w, "--output_path",
                                     w + "/meshed-visibility.ply"}));
  ExpectSuccess(RunProgram(
      "lsmvs", {"mesh_refiner", "--workspace_path", w, "--input_path", w + "/meshed-visibility.ply",
                "--output_path", w + "/meshed-refined.ply"}));
  EXPECT_EQ(ReadResults(whole.path()), ReadResults(staged.path()));
  const ProgramResult after = RunProgram("lsmvs-mesher", {w, "--quality", "extreme"});
  EXPECT_THAT(after.out, HasSubstr("everything is up to date"));
}

// A workspace with a fused.ply of somebody else's.
class ForeignCloud : public testing::Test {
 protected:
  ForeignCloud() {
    ExpectSuccess(RunProgram("lsmvs-mesher", {workspace_.text(), "--to", "stereo_fusion"}));
    fs::remove_all(workspace_ / "lsmvs");
    fs::remove_all(workspace_ / "stereo");
    fs::create_directory(workspace_ / "stereo");
    cloud_ = ReadText(workspace_ / "fused.ply");
  }
  SmallWorkspace workspace_;
  std::string cloud_;
};

TEST_F(ForeignCloud, IsUsedAndKept) {
  const ProgramResult result =
      RunProgram("lsmvs-mesher", {workspace_.text(), "--to", "visibility_mesher"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, HasSubstr("used as it is"));
  EXPECT_EQ(ReadText(workspace_ / "fused.ply"), cloud_);
  EXPECT_FALSE(fs::exists(workspace_ / "stereo/depth_maps"));
}

TEST_F(ForeignCloud, IsReplacedOnRequest) {
  WriteText(workspace_ / "fused.ply", "something else");
  ExpectSuccess(
      RunProgram("lsmvs-mesher", {workspace_.text(), "--to", "stereo_fusion", "--overwrite"}));
  EXPECT_EQ(ReadText(workspace_ / "fused.ply"), cloud_);
}

TEST_F(ForeignCloud, WithoutItsVisibilityIsAnError) {
  fs::remove(workspace_ / "fused.ply.vis");
  const ProgramResult result = RunProgram("lsmvs-mesher", {workspace_.text()});
  ExpectError(result, 6, {"fused.ply"});
}

TEST_F(ForeignCloud, OfAnotherNumberOfPointsThanItsVisibilityIsAnError) {
  const std::string vis = ReadText(workspace_ / "fused.ply.vis");
  WriteText(workspace_ / "fused.ply.vis", std::string(8, '\0'));
  ExpectError(RunProgram("lsmvs-mesher", {workspace_.text()}), 3, {"fused.ply"});
  WriteText(workspace_ / "fused.ply.vis", vis.substr(0, vis.size() - 3));
  ExpectError(RunProgram("lsmvs-mesher", {workspace_.text()}), 3, {"fused.ply.vis"});
  EXPECT_FALSE(fs::exists(workspace_ / "meshed-visibility.ply"));
}

TEST_F(ForeignCloud, AForeignMeshIsRefused) {
  WriteText(workspace_ / "meshed-visibility.ply", "theirs");
  ExpectError(RunProgram("lsmvs-mesher", {workspace_.text()}), 6,
              {"meshed-visibility.ply", "--overwrite"});
  EXPECT_EQ(ReadText(workspace_ / "meshed-visibility.ply"), "theirs");
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace_.text(), "--from", "visibility_mesher",
                                            "--to", "visibility_mesher", "--overwrite"}));
  EXPECT_EQ(ReadText(workspace_ / "fused.ply"), cloud_);
}

TEST(Resume, FromALaterStageNeedsWhatTheEarlierOnesMake) {
  const SmallWorkspace workspace;
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text(), "--from", "visibility_mesher"}), 3,
              {"fused.ply"});
  ExpectError(RunProgram("lsmvs-mesher",
                         {workspace.text(), "--from", "mesh_refiner", "--to", "stereo_fusion"}),
              2, {"--from"});
}

}  // namespace
}  // namespace lsmvs
