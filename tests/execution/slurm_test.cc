#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "job_run.h"
#include "job_tasks.h"
#include "lsmvs/execution/run_status.h"
#include "lsmvs/test_support/slurm_cluster.h"
#include "lsmvs/util/error.h"

// Against Slurm's own daemons.

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

EngineOptions Slurm() {
  EngineOptions options;
  options.kind = EngineKind::kSlurm;
  options.job_minutes = 0;
  return options;
}

void SleepMilliseconds(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

// Does something in the background once a file has appeared.
class Once {
 public:
  Once(fs::path file, std::function<void()> body)
      : thread_([this, file = std::move(file), body = std::move(body)] {
          while (!fs::exists(file) && !stop_) SleepMilliseconds(10);
          if (!stop_) body();
        }) {}
  ~Once() {
    stop_ = true;
    thread_.join();
  }
  Once(const Once&) = delete;
  Once& operator=(const Once&) = delete;

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::string ErrorOf(const std::function<void()>& body, ExitCode code) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

// Node that a job of the run is at.
std::string NodeAtWork() {
  std::string node = OutputOf("squeue -h -t running -o %N | head -1");
  while (!node.empty() && node.back() == '\n') node.pop_back();
  return node;
}

TEST(Slurm, GivesTheFilesOfALocalRun) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  run.Run(Slurm());
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(run.observer.Notes(), "");
  EXPECT_EQ(NumStarts(run.root(), "first0"), 1u);
  EXPECT_FALSE(fs::exists(run.root() / "lsmvs/jobs"));
  EXPECT_EQ(OutputOf("squeue -h"), "");
}

TEST(Slurm, LimitsAreThoseOfTheLargestNode) {
  LSMVS_REQUIRE_SLURM(cluster, 2, 3);
  const std::optional<JobLimits> limits = FindJobLimits(Slurm());
  ASSERT_TRUE(limits.has_value());
  EXPECT_EQ(limits->num_threads, 3);
  EXPECT_EQ(limits->memory_bytes, size_t{4000} << 20);
  EngineOptions other = Slurm();
  other.partition = "nowhere";
  EXPECT_THAT(ErrorOf([&] { FindJobLimits(other); }, ExitCode::kExternalTool),
              HasSubstr("nowhere"));
}

TEST(Slurm, AJobThatCrashesIsStartedAgain) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  AddHook(run.root(), "second4", "crash");
  run.Run(Slurm());
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_THAT(run.observer.Notes(), HasSubstr("of Slurm failed on n"));
  EXPECT_EQ(NumStarts(run.root(), "second4"), 2u);
}

TEST(Slurm, AJobThatTakesMoreMemoryThanItAskedForGetsMore) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  // A job asks for 256 MB at first, then for 512.
  AddHook(run.root(), "second4", "hold 400000000");
  AddHook(run.root(), "second4", "hold 400000000");
  run.Run(Slurm());
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_THAT(run.observer.Notes(), HasSubstr("took more memory than it had asked for"));
  EXPECT_THAT(run.observer.Notes(), HasSubstr("with more memory"));
  EXPECT_EQ(NumStarts(run.root(), "second4"), 2u);
}

// Slurm looks at limits once or twice a minute.
TEST(Slurm, AJobThatReachesItsTimeLimitIsStartedAgain) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  AddHook(run.root(), "second4", "sleep 300");
  EngineOptions options = Slurm();
  options.time = "1";
  run.Run(options);
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_THAT(run.observer.Notes(), HasSubstr("reached its time limit on n"));
  EXPECT_THAT(run.observer.Notes(), testing::Not(HasSubstr("with more time")));
  EXPECT_EQ(NumStarts(run.root(), "second4"), 2u);
}

TEST(Slurm, WorkOfANodeThatDiesIsDoneOnAnother) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  AddHook(run.root(), "first2", "sleep 60");
  {
    const Once kill(run.root() / "starts/first2", [&] {
      while (!fs::exists(run.root() / "maps/first5.n")) SleepMilliseconds(50);
      cluster.KillNode(NodeAtWork());
    });
    run.Run(Slurm());
  }
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_THAT(run.observer.Notes(), HasSubstr("was lost with its node"));
  EXPECT_EQ(NumStarts(run.root(), "first2"), 2u);
}

TEST(Slurm, JobsOfAKilledDriverAreWatchedByTheNext) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  AddHook(run.root(), "first0", "sleep 3");
  run.RunAndKill(Slurm(), run.root() / "starts/first0", 1);
  EXPECT_NE(OutputOf("squeue -h"), "");
  run.Run(Slurm());
  EXPECT_THAT(run.observer.Notes(), HasSubstr("goes on with"));
  EXPECT_EQ(run.Results(), LocalResults());
  for (const Task& task : MakeJobTasks(run.root(), "word")) {
    EXPECT_EQ(NumStarts(run.root(), task.name), 1u) << task.name;
  }
}

TEST(Slurm, AHandleThatWasNotNotedIsFoundByTheName) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  AddHook(run.root(), "first0", "sleep 3");
  run.RunAndKill(Slurm(), run.root() / "starts/first0", 0.2);
  ASSERT_TRUE(fs::remove(run.root() / "lsmvs/jobs/1/handle"));
  run.Run(Slurm());
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(NumStarts(run.root(), "first0"), 1u);
}

TEST(Slurm, AJobThatSomebodyCancelsEndsTheRunAndTheNextGoesOn) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  AddHook(run.root(), "first1", "sleep 60");
  const std::string message = ErrorOf(
      [&] {
        const Once cancel(run.root() / "starts/first1", [] { OutputOf("scancel 1_1"); });
        run.Run(Slurm());
      },
      ExitCode::kCancelled);
  EXPECT_THAT(message, HasSubstr("cancelled by somebody else"));
  run.Run(Slurm());
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(NumStarts(run.root(), "first0"), 1u);
}

TEST(Slurm, CancelEndsTheJobsOfTheRunAndNoOthers) {
  LSMVS_REQUIRE_SLURM(cluster);
  OutputOf("cd /tmp && sbatch --mem=100 --output=/dev/null --wrap='sleep 100'");
  JobRun run;
  AddHook(run.root(), "first0", "sleep 60");
  std::atomic<bool> cancel{false};
  {
    const Once stop(run.root() / "starts/first0", [&] { cancel = true; });
    EXPECT_THROW(run.Run(Slurm(), "word", &cancel), CancelledError);
  }
  SleepMilliseconds(1500);
  EXPECT_EQ(OutputOf("squeue -h -t pending,running -o %j"), "wrap\n");
}

TEST(Slurm, JobsThatWaitAreReportedAndShown) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  EngineOptions options = Slurm();
  options.extra = "--hold";
  {
    const Once release(run.root() / "lsmvs/jobs/1/handle", [&] {
      SleepMilliseconds(12000);
      const std::optional<RunStatus> status = ReadRunStatus(run.root());
      ASSERT_TRUE(status.has_value());
      EXPECT_EQ(status->jobs.waiting, 6u);
      EXPECT_THAT(status->jobs.reason, HasSubstr("JobHeld"));
      while (!fs::exists(run.root() / "all")) {
        OutputOf("squeue -h -t pending -o %A | xargs -r -n 1 scontrol release");
        SleepMilliseconds(300);
      }
    });
    run.Run(options);
  }
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_THAT(run.observer.Notes(), HasSubstr("6 jobs wait in the queue of Slurm: JobHeld"));
  EXPECT_THAT(run.observer.Notes(), HasSubstr("may never start"));
}

TEST(Slurm, OptionsThatItRefusesAreNamed) {
  LSMVS_REQUIRE_SLURM(cluster);
  JobRun run;
  EngineOptions options = Slurm();
  options.extra = "--qos=none --no-such-option";
  EXPECT_THAT(ErrorOf([&] { run.Run(options); }, ExitCode::kExternalTool),
              HasSubstr("no-such-option"));
}

}  // namespace
}  // namespace lsmvs
