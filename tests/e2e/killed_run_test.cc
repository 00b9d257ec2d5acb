#include <gtest/gtest.h>
#include <signal.h>

#include <random>

#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

constexpr int kNumKills = 20;

// Names of the results that differ or are missing on one side; empty if all bytes are the same.
std::string Differences(const SmallWorkspace& a, const SmallWorkspace& b) {
  const auto of_a = ReadResults(a.path()), of_b = ReadResults(b.path());
  std::string names;
  for (const auto& [name, bytes] : of_a) {
    if (!of_b.contains(name) || of_b.at(name) != bytes) names += name + " ";
  }
  for (const auto& [name, bytes] : of_b) {
    if (!of_a.contains(name)) names += name + " ";
  }
  return names;
}

TEST(KilledRun, TwentyKillsAtRandomMomentsEndWithTheSameBytes) {
  const SmallWorkspace undisturbed, killed;
  const ProgramResult whole = RunProgram("lsmvs-mesher", {undisturbed.text()});
  ExpectSuccess(whole);
  std::mt19937 random(3);
  const auto longest = static_cast<int>(whole.seconds * 0.4e6);
  int num_kills = 0;
  for (int attempt = 0; attempt < 10 * kNumKills && num_kills < kNumKills; ++attempt) {
    ProgramOptions options;
    options.signal_after =
        std::chrono::microseconds(std::uniform_int_distribution(1000, longest)(random));
    const ProgramResult result = RunProgram("lsmvs-mesher", {killed.text()}, options);
    if (result.signal == SIGKILL) {
      ++num_kills;
    } else {
      ExpectSuccess(result);
      // Start over.
      std::filesystem::remove_all(killed / "stereo/depth_maps");
      std::filesystem::remove(killed / "fused.ply");
      std::filesystem::remove(killed / "meshed-visibility.ply");
      std::filesystem::remove(killed / "meshed-refined.ply");
    }
  }
  ExpectSuccess(RunProgram("lsmvs-mesher", {killed.text()}));
  EXPECT_EQ(num_kills, kNumKills);
  EXPECT_EQ(Differences(undisturbed, killed), "");
  EXPECT_TRUE(FindLeftovers(killed.path()).empty());
}

TEST(Threads, OneAndTwoGiveTheSameBytes) {
  const SmallWorkspace one, two;
  ExpectSuccess(RunProgram("lsmvs-mesher", {one.text(), "--num_threads", "1"}));
  ExpectSuccess(RunProgram("lsmvs-mesher", {two.text(), "--num_threads", "2"}));
  EXPECT_EQ(Differences(one, two), "");
}

// Ctrl-C and SIGTERM: code 130, one line, nothing half-written, and the next run ends the work.
class Stopped : public testing::TestWithParam<int> {};

TEST_P(Stopped, EndsCleanlyAndGoesOn) {
  const ProgramResult whole = RunProgram("lsmvs-mesher", {SmallWorkspace().text()});
  ProgramOptions options;
  options.signal = GetParam();
  // A run that ends before its signal, on a machine with much else to do, is tried again, with an
  // earlier one.
  for (double share = 0.6; share > 0.05; share *= 0.8) {
    const SmallWorkspace workspace;
    options.signal_after = std::chrono::microseconds(static_cast<int>(whole.seconds * share * 1e6));
    const ProgramResult stopped = RunProgram("lsmvs-mesher", {workspace.text()}, options);
    if (stopped.exit_code == 0) continue;
    ExpectError(stopped, 130, {"cancelled"});
    EXPECT_TRUE(FindLeftovers(workspace.path()).empty());
    ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
    return;
  }
  FAIL() << "no run was stopped";
}

INSTANTIATE_TEST_SUITE_P(Signals, Stopped, testing::Values(SIGINT, SIGTERM));

}  // namespace
}  // namespace lsmvs
