#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include <cstdlib>

#include "lsmvs/colmap_adapter/colmap_runner.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;

const std::vector<std::string>& CommandNames() {
  static const std::vector<std::string> names = {
      "quasi_dense_matcher", "patch_match_stereo", "stereo_fusion",   "visibility_mesher",
      "mesh_refiner",        "mesh_texturer",      "mesh_simplifier", "mesh_evaluator",
      "mesh_renderer",       "mesh_comparer",      "mesh_exporter",   "mesh_merger"};
  return names;
}

TEST(Programs, HelpAllNamesOptionsDefaultsAndExitCodes) {
  for (const std::string& name : CommandNames()) {
    const ProgramResult result = RunProgram("lsmvs", {name, "--help_all"});
    ExpectSuccess(result);
    for (const char* text :
         {"Usage:", "Exit codes:", "--num_threads", "--project_path", "Default:"}) {
      EXPECT_THAT(result.out, HasSubstr(text)) << name;
    }
  }
  const ProgramResult mesher = RunProgram("lsmvs-mesher", {"--help_all"});
  ExpectSuccess(mesher);
  EXPECT_THAT(mesher.out, HasSubstr("meshed-refined.ply"));
  EXPECT_THAT(mesher.out, HasSubstr("--StereoFusion.min_num_pixels"));
}

TEST(Programs, HelpFitsAScreen) {
  for (const std::string& name : CommandNames()) {
    for (const char* help : {"-h", "--help"}) {
      const ProgramResult result = RunProgram("lsmvs", {name, help});
      ExpectSuccess(result);
      for (const char* text : {"Usage:", "Examples:", "Required.", "--num_threads", "--help_all"}) {
        EXPECT_THAT(result.out, HasSubstr(text)) << name;
      }
      EXPECT_LE(std::count(result.out.begin(), result.out.end(), '\n'), 61) << name;
    }
  }
  const std::string mesher = RunProgram("lsmvs-mesher", {"--help"}).out;
  EXPECT_LE(std::count(mesher.begin(), mesher.end(), '\n'), 61);
  // What few need is named, and told by --help_all.
  EXPECT_THAT(mesher, HasSubstr("Rarely needed: --image_path"));
  EXPECT_THAT(mesher, testing::Not(HasSubstr("--submit_command TEXT")));
  EXPECT_THAT(RunProgram("lsmvs-mesher", {"--help_all"}).out, HasSubstr("--submit_command TEXT"));
}

TEST(Programs, VersionAndList) {
  EXPECT_THAT(RunProgram("lsmvs", {"--version"}).out, HasSubstr("lsmvs "));
  EXPECT_THAT(RunProgram("lsmvs-mesher", {"--version"}).out, HasSubstr("lsmvs "));
  EXPECT_THAT(RunProgram("lsmvs", {"help"}).out, HasSubstr("stereo_fusion"));
  EXPECT_EQ(RunProgram("lsmvs", {}).exit_code, 2);
}

TEST(Programs, WrongOptionsAreRefusedWithAHint) {
  ExpectError(RunProgram("lsmvs", {"stereo_fusion", "--workspce_path", "x"}), 2,
              {"--workspce_path", "did you mean --workspace_path?"});
  ExpectError(RunProgram("lsmvs", {"stereo_fuson"}), 2, {"did you mean 'stereo_fusion'?"});
  ExpectError(RunProgram("lsmvs", {"stereo_fusion"}), 2, {"--workspace_path is missing"});
  ExpectError(RunProgram("lsmvs-mesher", {}), 2, {"workspace"});
  ExpectError(RunProgram("lsmvs-mesher", {"x", "--quality", "best"}), 2,
              {"low, medium, high, extreme"});
  ExpectError(RunProgram("lsmvs-mesher", {"x", "--num_threads", "0"}), 2, {"--num_threads"});
  ExpectError(RunProgram("lsmvs-mesher", {"x", "--max_memory", "much"}), 2, {"--max_memory"});
  ExpectError(RunProgram("lsmvs-mesher", {"x", "--bounding_box", "0,0,0"}), 2, {"--bounding_box"});
  ExpectError(RunProgram("lsmvs-mesher", {"x", "--StereoFusion.min_num_pixels", "0"}), 2,
              {"--StereoFusion.min_num_pixels"});
  ExpectError(RunProgram("lsmvs-mesher", {"x", "--project_path", "/nowhere.ini"}), 3,
              {"/nowhere.ini"});
}

TEST(Programs, IniFileIsUsedAndTheCommandLineWins) {
  const SmallWorkspace workspace;
  WriteText(workspace / "x.ini", "to=stereo_fusion\n[StereoFusion]\nmin_num_pixels=100\n");
  const std::string ini = (workspace / "x.ini").string();
  // No point is seen by 100 photos.
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text(), "--project_path", ini}), 3,
              {"fused.ply"});
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--project_path", ini,
                                            "--StereoFusion.min_num_pixels", "2"}));
  EXPECT_FALSE(std::filesystem::exists(workspace / "meshed-visibility.ply"));
}

TEST(Programs, PlanIsPrintedBeforeAndResultsAfter) {
  const SmallWorkspace workspace;
  const ProgramResult result = RunProgram("lsmvs-mesher", {workspace.text()});
  ExpectSuccess(result);
  for (const char* text : {"5 views", "megapixels", "patch_match_stereo", "mesh_refiner", "MB",
                           "results", "meshed-refined.ply", "written"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_THAT(result.err, HasSubstr("stereo_fusion: done in"));
}

// What `colmap mapper` leaves: the photos are undistorted first, by colmap itself.
TEST(Programs, AProjectFolderIsUndistortedFirst) {
  ASSERT_TRUE(ColmapRunner().available()) << "scripts/setup.sh installs colmap";
  const SmallWorkspace workspace;
  std::filesystem::remove_all(workspace / "stereo");
  std::filesystem::rename(workspace / "sparse", workspace / "model");
  std::filesystem::create_directory(workspace / "sparse");
  std::filesystem::rename(workspace / "model", workspace / "sparse/0");
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
  EXPECT_TRUE(std::filesystem::exists(workspace / "dense/0/meshed-refined.ply"));
  EXPECT_TRUE(std::filesystem::exists(workspace / "dense/0/meshed-visibility.ply.vis"));
  EXPECT_THAT(RunProgram("lsmvs-mesher", {workspace.text()}).out,
              HasSubstr("everything is up to date"));
}

TEST(Programs, AProjectWithoutColmapSaysSo) {
  const SmallWorkspace workspace;
  std::filesystem::remove_all(workspace / "stereo");
  ProgramOptions options;
  options.before_exec = [] { ::setenv("COLMAP", "/nowhere/colmap", 1); };
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text()}, options), 7, {"colmap"});
}

}  // namespace
}  // namespace lsmvs
