// The memory that a plan names against what the kernel counts for the process, from outside.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/town.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"
#include "lsmvs/util/memory.h"
#include "plan_figures.h"
#include "program_runner.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

constexpr double kTolerance = 0.2;

void ExpectNearPart(double planned, double measured, double part, const std::string& what) {
  EXPECT_NEAR(planned, measured, part * measured) << what;
  testing::Test::RecordProperty(what, std::to_string(planned / measured));
}

// Peaks of the stages, as the program itself noted them.
std::map<std::string, double> ReadStagePeaks(const fs::path& workspace) {
  std::ifstream file(workspace / "lsmvs/run.json");
  std::map<std::string, double> peaks;
  const nlohmann::json record = nlohmann::json::parse(file);
  for (const auto& [stage, groups] : record.at("stages").items()) {
    for (const auto& group : groups) {
      peaks[stage] = std::max(peaks[stage], group.at("peak_bytes").get<double>());
    }
  }
  return peaks;
}

void ExpectPlanHolds(const fs::path& workspace, const ProgramResult& result) {
  ExpectSuccess(result);
  // Else the kernel would count this process.
  ASSERT_LT(ResidentBytes(), result.peak_bytes);
  const auto measured = static_cast<double>(result.peak_bytes);
  double highest = 0;
  for (const auto& [stage, peak] : ReadStagePeaks(workspace)) {
    ExpectNearPart(ReadPlanFigures(result.out, stage).memory_bytes, peak, kTolerance, stage);
    highest = std::max(highest, peak);
  }
  ExpectNearPart(ReadPlanFigures(result.out, "all").memory_bytes, measured, kTolerance, "all");
  // Nothing that the program says of itself hides what it took.
  ExpectNearPart(highest, measured, 0.03, "by itself");
}

// A scene of the tests' data as a dense workspace, which its photos are ready for.
void CopyScene(const std::string& scene, const fs::path& workspace) {
  fs::copy(TestDataFolder() / scene, workspace, fs::copy_options::recursive);
  for (const auto& entry : fs::recursive_directory_iterator(workspace)) {
    fs::permissions(entry.path(), fs::perms::owner_write, fs::perm_options::add);
  }
  fs::permissions(workspace, fs::perms::owner_write, fs::perm_options::add);
  fs::create_directory(workspace / "stereo");
}

TEST(MemoryPlan, HoldsOnARenderedSceneAndRefusesOnBothSidesOfIt) {
  SKIP_WITH_SANITIZERS;
  const TemporaryFolder folder;
  const fs::path workspace = folder.path() / "w";
  {
    SyntheticSceneOptions options;
    options.shape = ShapeName::kRelief;
    options.num_views = 6;
    options.width = 640;
    options.height = 480;
    options.num_sparse_points = 3000;
    const RunContext context(2);
    SyntheticScene scene = MakeScene(options, context);
    WriteWorkspace(workspace, WorkspaceFormat::kDense, &scene, context);
  }
  ReturnFreedMemory();
  const ProgramResult result = RunProgram("lsmvs-mesher", {workspace.string()});
  ExpectPlanHolds(workspace, result);
  const double peak = ReadStagePeaks(workspace)["patch_match_stereo"];
  fs::remove_all(workspace / "lsmvs");
  for (const char* maps : {"stereo/depth_maps", "stereo/normal_maps"}) {
    fs::remove_all(workspace / maps);
  }
  for (const char* name : {"fused.ply", "meshed-visibility.ply", "meshed-refined.ply"}) {
    fs::remove(workspace / name);
  }
  const auto with_memory = [&](double part) {
    const std::string limit = std::to_string(static_cast<int>(part * peak / 1e6)) + "MB";
    return RunProgram("lsmvs-mesher",
                      {workspace.string(), "--to", "patch_match_stereo", "--max_memory", limit});
  };
  ExpectError(with_memory(0.75), 5, {"patch_match_stereo", "--max_memory"});
  ExpectSuccess(with_memory(1.3));
}

TEST(MemoryPlan, HoldsOnACloudOfAnotherProgram) {
  SKIP_WITH_SANITIZERS;
  LSMVS_REQUIRE_SCENE("fountain-P11-fused");
  const TemporaryFolder folder;
  const fs::path workspace = folder.path() / "w";
  CopyScene("fountain-P11-fused", workspace);
  const ProgramResult result =
      RunProgram("lsmvs", {"visibility_mesher", "--input_path", workspace.string(), "--output_path",
                           (workspace / "mesh.ply").string()});
  ExpectPlanHolds(workspace, result);
}

// Nothing tells how densely the points lie but the cloud itself.
TEST(MemoryPlan, HoldsOnACloudWithoutSparsePoints) {
  SKIP_WITH_SANITIZERS;
  const TemporaryFolder folder;
  TownOptions options;
  options.num_points = 1e6;
  WriteTown(folder.path(), Town(options), 1, RunContext(2));
  ReturnFreedMemory();
  const ProgramResult result =
      RunProgram("lsmvs", {"visibility_mesher", "--input_path", folder.path().string(),
                           "--output_path", (folder.path() / "mesh.ply").string()});
  ExpectPlanHolds(folder.path(), result);
}

// Reduced, so that all of them take about a minute.
class MemoryPlanOfScene : public testing::TestWithParam<const char*> {};

TEST_P(MemoryPlanOfScene, Holds) {
  SKIP_WITH_SANITIZERS;
  LSMVS_REQUIRE_SCENE(GetParam());
  const TemporaryFolder folder;
  const fs::path workspace = folder.path() / "w";
  CopyScene(GetParam(), workspace);
  ExpectPlanHolds(workspace,
                  RunProgram("lsmvs-mesher", {workspace.string(), "--max_image_size", "480"}));
}

INSTANTIATE_TEST_SUITE_P(Scenes, MemoryPlanOfScene,
                         testing::Values("fountain-P11", "Herz-Jesus-P8", "syn-facade", "syn-igea",
                                         "drone-park"));

}  // namespace
}  // namespace lsmvs
