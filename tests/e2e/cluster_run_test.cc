#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

#include "lsmvs/test_support/slurm_cluster.h"
#include "lsmvs/util/child_process.h"
#include "program_runner.h"
#include "small_workspace.h"

// The same reconstruction by several processes and machines, from photos to the refined mesh.

namespace lsmvs {
namespace {

using testing::HasSubstr;

const std::map<std::string, std::string>& LocalResults() {
  static const std::map<std::string, std::string> results = [] {
    const SmallWorkspace workspace;
    ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
    return ReadResults(workspace.path());
  }();
  return results;
}

// Names of the files that are not as a local run leaves them.
std::string Differences(const SmallWorkspace& workspace) {
  const auto results = ReadResults(workspace.path());
  std::string names;
  for (const auto& [name, bytes] : LocalResults()) {
    if (!results.contains(name) || results.at(name) != bytes) names += name + " ";
  }
  for (const auto& [name, bytes] : results) {
    if (!LocalResults().contains(name)) names += name + " ";
  }
  return names;
}

class CommandEngine : public testing::TestWithParam<std::string> {};

TEST_P(CommandEngine, GivesTheBytesOfALocalRun) {
  if (GetParam().starts_with("parallel") && FindExecutable("parallel").empty()) {
    GTEST_SKIP() << "GNU parallel is not installed";
  }
  const SmallWorkspace workspace;
  const ProgramResult result =
      RunProgram("lsmvs-mesher", {workspace.text(), "--engine", "command", "--submit_command",
                                  GetParam(), "--job_minutes", "0"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, HasSubstr("a single job, not divided"));
  EXPECT_EQ(Differences(workspace), "");
}

INSTANTIATE_TEST_SUITE_P(Commands, CommandEngine,
                         testing::Values("sh {commands}",
                                         "xargs -d '\\n' -P 2 -n 1 sh -c < {commands}",
                                         "parallel --will-cite -j 2 -a {commands}"));

TEST(ClusterOptions, ThatDoNotFitTogetherAreRefused) {
  const SmallWorkspace workspace;
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text(), "--engine", "command"}), 2,
              {"submit_command"});
}

TEST(RunStatus, SaysThatNoRunIsAtWork) {
  const SmallWorkspace workspace;
  const ProgramResult before = RunProgram("lsmvs", {"run_status", workspace.text()});
  ExpectSuccess(before);
  EXPECT_THAT(before.out, HasSubstr("no run is at work"));
  EXPECT_THAT(before.out, HasSubstr("nothing is on record"));
}

// A node dies, then the driver; the next one ends the run.
TEST(SlurmRun, ANodeAndTheDriverDieAndTheBytesAreThoseOfALocalRun) {
  LSMVS_REQUIRE_SLURM(cluster);
  const SmallWorkspace workspace;
  const std::vector<std::string> arguments = {workspace.text(), "--engine", "slurm",
                                              "--job_minutes", "0"};
  const auto has_map = [&](const std::string& kind) {
    const std::string command =
        "ls '" + (workspace / "stereo/depth_maps").string() + "' 2>/dev/null | grep -c " + kind;
    return OutputOf(command) != "0\n";
  };
  ProgramOptions options;
  std::atomic<bool> node_killed{false};
  std::string status;
  options.signal_when = [&] {
    if (!node_killed && has_map("photometric")) {
      status = RunProgram("lsmvs", {"run_status", workspace.text()}).out;
      cluster.KillNode("n2");
      node_killed = true;
    }
    return node_killed && has_map("geometric");
  };
  const ProgramResult killed = RunProgram("lsmvs-mesher", arguments, options);
  ASSERT_EQ(killed.signal, SIGKILL) << killed.err;
  EXPECT_THAT(status, HasSubstr("patch_match_stereo"));
  EXPECT_THAT(status, HasSubstr("jobs:"));
  cluster.StartNode("n2");
  ExpectSuccess(RunProgram("lsmvs-mesher", arguments));
  EXPECT_EQ(Differences(workspace), "");
  EXPECT_EQ(OutputOf("squeue -h"), "");
}

TEST(SlurmRun, SingleStagesRunThereToo) {
  LSMVS_REQUIRE_SLURM(cluster);
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram(
      "lsmvs", {"patch_match_stereo", workspace.text(), "--engine", "slurm",
                "--keep_photometric_maps", "0", "--PatchMatchStereo.max_image_size", "2400"}));
  for (const auto& [name, bytes] : ReadResults(workspace.path())) {
    if (name.find("geometric") != std::string::npos) {
      EXPECT_EQ(bytes, LocalResults().at(name)) << name;
    }
  }
}

TEST(SlurmRun, CtrlCCancelsTheJobs) {
  LSMVS_REQUIRE_SLURM(cluster);
  const SmallWorkspace workspace;
  ProgramOptions options;
  options.signal = SIGINT;
  bool is_sent = false;
  options.signal_when = [&] {
    const bool now = !is_sent && OutputOf("squeue -h -t running") != "";
    is_sent = is_sent || now;
    return now;
  };
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text(), "--engine", "slurm"}, options), 130,
              {"cancelled"});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_EQ(OutputOf("squeue -h -t pending,running"), "");
}

}  // namespace
}  // namespace lsmvs
