// The disk that a plan names, and the maps that a run leaves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "plan_figures.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

int CountMaps(const SmallWorkspace& workspace, const std::string& kind) {
  int count = 0;
  for (const char* folder : {"stereo/depth_maps", "stereo/normal_maps"}) {
    for (const auto& entry : fs::directory_iterator(workspace / folder)) {
      count += entry.path().string().ends_with("." + kind + ".bin");
    }
  }
  return count;
}

constexpr int kNumMaps = 2 * 5;

TEST(DiskPlan, TheMesherDropsPhotometricMapsAndNothingMissesThem) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
  EXPECT_EQ(CountMaps(workspace, "photometric"), 0);
  EXPECT_EQ(CountMaps(workspace, "geometric"), kNumMaps);
  EXPECT_THAT(RunProgram("lsmvs-mesher", {workspace.text()}).out,
              testing::HasSubstr("everything is up to date"));
  // A map that is gone is made again, with what it needs, and gives the same.
  const auto before = ReadResults(workspace.path());
  for (const auto& entry : fs::directory_iterator(workspace / "stereo/depth_maps")) {
    fs::remove(entry.path());
    break;
  }
  fs::remove(workspace / "fused.ply");
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "stereo_fusion"}));
  EXPECT_EQ(ReadResults(workspace.path()), before);
}

TEST(DiskPlan, PhotometricMapsAreKeptOnDemandAndByTheCommandForStereoAlone) {
  const SmallWorkspace kept, stereo, dropped;
  ExpectSuccess(RunProgram("lsmvs-mesher",
                           {kept.text(), "--to", "stereo_fusion", "--keep_photometric_maps", "1"}));
  EXPECT_EQ(CountMaps(kept, "photometric"), kNumMaps);
  ExpectSuccess(RunProgram("lsmvs", {"patch_match_stereo", "--workspace_path", stereo.text()}));
  EXPECT_EQ(CountMaps(stereo, "photometric"), kNumMaps);
  EXPECT_EQ(CountMaps(stereo, "geometric"), kNumMaps);
  // What the user had made to be kept stays when the mesher goes on.
  ExpectSuccess(
      RunProgram("lsmvs-mesher", {stereo.text(), "--to", "stereo_fusion", "--quality", "extreme"}));
  EXPECT_EQ(CountMaps(stereo, "photometric"), kNumMaps);
  ExpectSuccess(RunProgram("lsmvs", {"patch_match_stereo", "--workspace_path", dropped.text(),
                                     "--keep_photometric_maps", "0"}));
  EXPECT_EQ(CountMaps(dropped, "photometric"), 0);
  EXPECT_EQ(CountMaps(dropped, "geometric"), kNumMaps);
}

TEST(DiskPlan, MapsTakeWhatThePlanSays) {
  const SmallWorkspace workspace;
  const ProgramResult result =
      RunProgram("lsmvs", {"patch_match_stereo", "--workspace_path", workspace.text()});
  ExpectSuccess(result);
  double bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(workspace / "stereo")) {
    if (entry.path().extension() == ".bin") bytes += static_cast<double>(entry.file_size());
  }
  const double planned = ReadPlanFigures(result.out, "patch_match_stereo").disk_bytes;
  // Printed in whole megabytes, rounded up.
  EXPECT_GE(planned, bytes);
  EXPECT_LE(planned, bytes + 1e6);
}

}  // namespace
}  // namespace lsmvs
