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

size_t NumPoints(const fs::path& cloud) { return PlyReader(cloud).FindElement("vertex")->count; }

TEST(QuasiDenseRun, LowQualityTakesItsPointsFromInterestPoints) {
  const SmallWorkspace workspace;
  const ProgramResult result = RunProgram("lsmvs-mesher", {workspace.text(), "--quality", "low"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, HasSubstr("quasi_dense_matcher"));
  EXPECT_THAT(result.out, Not(HasSubstr("patch_match_stereo")));
  EXPECT_THAT(result.err, HasSubstr("quasi_dense_matcher: done in"));
  EXPECT_FALSE(fs::exists(workspace / "stereo/depth_maps/0000.png.geometric.bin"));
  EXPECT_GT(ReadMeshPly(workspace / "meshed-refined.ply").faces.size(), 100u);
  const std::string record = ReadText(workspace / "lsmvs/run.json");
  for (const char* text :
       {"\"quasi_dense_matcher\"", "QuasiDenseMatching.min_ncc", "interest_points"}) {
    EXPECT_THAT(record, HasSubstr(text));
  }
  EXPECT_THAT(RunProgram("lsmvs-mesher", {workspace.text(), "--quality", "low"}).out,
              HasSubstr("everything is up to date"));
}

TEST(QuasiDenseRun, ThePointSourceMayBeChosenForAnyQuality) {
  const SmallWorkspace low, medium;
  const ProgramResult patch_match = RunProgram(
      "lsmvs-mesher",
      {low.text(), "--quality", "low", "--point_source", "patch_match", "--to", "stereo_fusion"});
  ExpectSuccess(patch_match);
  EXPECT_THAT(patch_match.out, HasSubstr("patch_match_stereo"));
  const ProgramResult quasi_dense =
      RunProgram("lsmvs-mesher", {medium.text(), "--quality", "medium", "--point_source",
                                  "quasi_dense", "--to", "quasi_dense_matcher"});
  ExpectSuccess(quasi_dense);
  EXPECT_THAT(quasi_dense.out, HasSubstr("quasi_dense_matcher"));
  EXPECT_FALSE(fs::exists(medium / "meshed-visibility.ply"));
}

TEST(QuasiDenseRun, TheStageAsACommandGivesTheBytesOfTheWholeRun) {
  const SmallWorkspace whole, staged;
  const std::string w = staged.text();
  ExpectSuccess(RunProgram("lsmvs-mesher", {whole.text(), "--quality", "extreme", "--point_source",
                                            "quasi_dense", "--num_threads", "2"}));
  ExpectSuccess(RunProgram("lsmvs", {"quasi_dense_matcher", "--workspace_path", w, "--output_path",
                                     w + "/fused.ply", "--num_threads", "1"}));
  EXPECT_EQ(ReadText(whole / "fused.ply"), ReadText(staged / "fused.ply"));
  EXPECT_EQ(ReadText(whole / "fused.ply.vis"), ReadText(staged / "fused.ply.vis"));
  const ProgramResult rest = RunProgram(
      "lsmvs-mesher",
      {w, "--quality", "extreme", "--point_source", "quasi_dense", "--num_threads", "1"});
  ExpectSuccess(rest);
  EXPECT_THAT(rest.err, Not(HasSubstr("quasi_dense_matcher: started")));
  EXPECT_EQ(ReadResults(whole.path()), ReadResults(staged.path()));
}

TEST(QuasiDenseRun, ChangingTheSourceReplacesOurCloudAndKeepsAForeignOne) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "stereo_fusion"}));
  const std::string fused = ReadText(workspace / "fused.ply");
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--point_source", "quasi_dense",
                                            "--to", "quasi_dense_matcher"}));
  EXPECT_NE(ReadText(workspace / "fused.ply"), fused);
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "stereo_fusion"}));
  EXPECT_EQ(ReadText(workspace / "fused.ply"), fused);
  fs::remove_all(workspace / "lsmvs");
  const ProgramResult foreign = RunProgram(
      "lsmvs-mesher",
      {workspace.text(), "--point_source", "quasi_dense", "--to", "quasi_dense_matcher"});
  ExpectSuccess(foreign);
  EXPECT_THAT(foreign.out, HasSubstr("used as it"));
  EXPECT_EQ(ReadText(workspace / "fused.ply"), fused);
}

TEST(QuasiDenseRun, StagesOfTheOtherSourceAreNamed) {
  for (const char* option : {"--from", "--to"}) {
    ExpectError(RunProgram("lsmvs-mesher", {"x", "--quality", "low", option, "stereo_fusion"}), 2,
                {"stereo_fusion is no stage of --point_source quasi_dense",
                 "quasi_dense_matcher, visibility_mesher, mesh_refiner"});
    ExpectError(RunProgram("lsmvs-mesher", {"x", option, "quasi_dense_matcher"}), 2,
                {"quasi_dense_matcher is no stage of --point_source patch_match"});
  }
}

// What keeps points out, for both sources of them.
class Sources : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  // Number of points with further arguments.
  size_t Run(const SmallWorkspace& workspace, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {workspace.text()};
    arguments.insert(arguments.end(), GetParam().begin(), GetParam().end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    ExpectSuccess(RunProgram("lsmvs-mesher", arguments));
    return NumPoints(workspace / "fused.ply");
  }
};

TEST_P(Sources, ABoundingBoxKeepsWhatIsInside) {
  const SmallWorkspace workspace;
  const size_t whole = Run(workspace, {});
  const size_t half = Run(workspace, {"--bounding_box", "-100,-100,-100,0,100,100"});
  EXPECT_LT(half, whole * 3 / 4);
  EXPECT_GT(half, whole / 4);
  for (const Eigen::Vector3d& x : ReadMeshPly(workspace / "fused.ply").vertices) {
    EXPECT_LE(x.x(), 1e-4);
  }
}

TEST_P(Sources, MaskedPixelsGiveNoPoints) {
  const SmallWorkspace workspace;
  const size_t whole = Run(workspace, {});
  // The lower half of every photo is black; the format is told by the content.
  const std::string mask =
      "P5\n128 96\n255\n" + std::string(128 * 48, '\xff') + std::string(128 * 48, '\0');
  for (const auto& entry : fs::directory_iterator(workspace / "images")) {
    WriteText(workspace / ("masks/" + entry.path().filename().string() + ".png"), mask);
  }
  const size_t masked = Run(workspace, {"--mask_path", (workspace / "masks").string()});
  EXPECT_LT(masked, whole * 3 / 4);
  EXPECT_GT(masked, whole / 4);
}

INSTANTIATE_TEST_SUITE_P(Points, Sources,
                         testing::Values(std::vector<std::string>{"--to", "stereo_fusion"},
                                         std::vector<std::string>{"--point_source", "quasi_dense",
                                                                  "--to", "quasi_dense_matcher"}),
                         [](const auto& source) {
                           return source.index == 0 ? "PatchMatch" : "QuasiDense";
                         });

}  // namespace
}  // namespace lsmvs
