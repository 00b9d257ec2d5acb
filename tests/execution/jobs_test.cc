#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <numeric>
#include <thread>

#include "job_run.h"
#include "job_tasks.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/execution/jobs/job_needs.h"
#include "lsmvs/execution/jobs/ready_tasks.h"
#include "lsmvs/execution/jobs/task_slices.h"
#include "lsmvs/execution/run_status.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/util/child_process.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kShell = "sh {commands}";

std::string MessageOf(const std::function<void()>& body, ExitCode code) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

class Commands : public testing::TestWithParam<std::string> {};

TEST_P(Commands, GiveTheFilesOfALocalRun) {
  if (GetParam().starts_with("parallel") && FindExecutable("parallel").empty()) {
    GTEST_SKIP() << "GNU parallel is not installed";
  }
  JobRun run;
  run.Run(CommandEngine(GetParam()));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(run.observer.Notes(), "");
  for (const Task& task : MakeJobTasks(run.root(), "word")) {
    EXPECT_EQ(NumStarts(run.root(), task.name), 1u);
  }
  EXPECT_FALSE(fs::exists(run.root() / "lsmvs/jobs"));
  EXPECT_FALSE(fs::exists(run.root() / "lsmvs/status.json"));
}

INSTANTIATE_TEST_SUITE_P(Engines, Commands,
                         testing::Values(kShell, "xargs -d '\\n' -P 2 -n 1 sh -c < {commands}",
                                         "seq {count} | xargs -P 2 -n 1 {script}",
                                         "for i in $(seq {count}); do PBS_ARRAY_INDEX=$i {script} "
                                         "|| exit 1; done",
                                         "parallel --will-cite -j 2 -a {commands}"));

TEST(Jobs, ATaskThatIsNotDividedIsHelped) {
  JobRun run;
  run.Run(CommandEngine("xargs -d '\\n' -P 3 -n 1 sh -c < {commands}"));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_GT(NumStarts(run.root(), "helper"), 0u);
  EXPECT_EQ(NumStarts(run.root(), "all"), 1u);
  EXPECT_EQ(run.observer.Notes(), "");
}

TEST(Jobs, AHelperThatCrashesChangesNothing) {
  JobRun run;
  AddHook(run.root(), "helper", "crash");
  run.Run(CommandEngine("xargs -d '\\n' -P 3 -n 1 sh -c < {commands}"));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_GT(NumStarts(run.root(), "helper"), 0u);
}

// What is short, and what must not be, has none.
TEST(Jobs, HelpersAreAsManyAsAreOfUse) {
  Task task;
  PlannedTask planned;
  task.max_helpers = 5;
  task.cost.cpu_seconds = 1000;
  EngineOptions options;
  EXPECT_EQ(NumHelpers(task, planned, 1, 100, options), 5u);
  EXPECT_EQ(NumHelpers(task, planned, 1, 3, options), 2u);
  EXPECT_EQ(NumHelpers(task, planned, 1, 1, options), 0u);
  task.cost.cpu_seconds = 17;
  EXPECT_EQ(NumHelpers(task, planned, 1, 100, options), 2u);
  EXPECT_EQ(NumHelpers(task, planned, 4, 100, options), 0u);
  options.job_minutes = 0;
  EXPECT_EQ(NumHelpers(task, planned, 4, 100, options), 5u);
  planned.resident_bytes = 1000;  // works with a scratch file
  EXPECT_EQ(NumHelpers(task, planned, 4, 100, options), 0u);
  planned.resident_bytes = 0;
  task.max_helpers = 0;
  EXPECT_EQ(NumHelpers(task, planned, 1, 100, options), 0u);
}

TEST(Jobs, SeveralTasksShareAJob) {
  JobRun run;
  EngineOptions options = CommandEngine("echo {count} >> counts; sh {commands}");
  options.submit_command =
      "echo {count} >> " + (run.root() / "starts/counts").string() + "; sh {commands}";
  fs::create_directories(run.root() / "starts");
  options.job_minutes = 5;
  options.jobs_at_once = 1;
  run.Run(options);
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(ReadText(run.root() / "starts/counts"), "1\n1\n1\n");
}

TEST(Jobs, AJobThatCrashesIsStartedAgain) {
  JobRun run;
  AddHook(run.root(), "first3", "crash");
  AddHook(run.root(), "first3", "crash");
  AddHook(run.root(), "all", "crash");
  run.Run(CommandEngine("sh {commands}; true"));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(NumStarts(run.root(), "first3"), 3u);
  EXPECT_EQ(NumStarts(run.root(), "first2"), 1u);
  EXPECT_THAT(run.observer.Notes(), HasSubstr("submitted again"));
}

TEST(Jobs, AJobThatAlwaysCrashesEndsTheRunWithItsLog) {
  JobRun run;
  for (int i = 0; i < 5; ++i) AddHook(run.root(), "second1", "crash");
  EngineOptions options = CommandEngine("sh {commands}");
  options.max_attempts = 2;
  const std::string message = MessageOf([&] { run.Run(options); }, ExitCode::kExternalTool);
  EXPECT_THAT(message, HasSubstr("second1: failed 2 times"));
  EXPECT_THAT(message, HasSubstr(".log"));
  EXPECT_EQ(NumStarts(run.root(), "second1"), 2u);
  fs::remove_all(run.root() / "hooks");
  run.Run(CommandEngine(kShell));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(NumStarts(run.root(), "first0"), 1u) << "finished work was done again";
}

TEST(Jobs, ATaskThatFindsItsInputWrongEndsTheRunAtOnce) {
  JobRun run;
  AddHook(run.root(), "first1", "wrong");
  const std::string message =
      MessageOf([&] { run.Run(CommandEngine(kShell)); }, ExitCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("photo: is dark; take another"));
  EXPECT_EQ(NumStarts(run.root(), "first1"), 1u);
}

TEST(Jobs, MemoryIsRaisedAfterATaskThatDidNotFit) {
  JobRun run;
  AddHook(run.root(), "second2", "memory 400000000");
  AddHook(run.root(), "second2", "memory 400000000");
  run.Run(CommandEngine(kShell));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(NumStarts(run.root(), "second2"), 2u);
  EXPECT_THAT(run.observer.Notes(), HasSubstr("second2: failed"));
}

TEST(Jobs, ASubmitCommandThatFailsSaysSo) {
  JobRun run;
  EngineOptions options = CommandEngine("echo no such queue; exit 3 # {commands}");
  options.max_attempts = 1;
  const std::string message = MessageOf([&] { run.Run(options); }, ExitCode::kExternalTool);
  EXPECT_THAT(message, HasSubstr("no such queue"));
}

TEST(Jobs, JobsOfAKilledDriverAreWatchedByTheNext) {
  JobRun run;
  AddHook(run.root(), "first0", "sleep 1.5");
  run.RunAndKill(CommandEngine(kShell), run.root() / "starts/first0", 0.3);
  EXPECT_FALSE(fs::exists(run.root() / "all"));
  const std::optional<RunStatus> status = ReadRunStatus(run.root());
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(status->stage, "passes");
  run.Run(CommandEngine(kShell));
  EXPECT_THAT(run.observer.Notes(), HasSubstr("goes on with"));
  EXPECT_EQ(run.Results(), LocalResults());
  for (const Task& task : MakeJobTasks(run.root(), "word")) {
    EXPECT_EQ(NumStarts(run.root(), task.name), 1u) << task.name;
  }
}

TEST(Jobs, JobsOfAKilledDriverOfOtherOptionsAreNotUsed) {
  JobRun run;
  AddHook(run.root(), "first0", "sleep 3");
  run.RunAndKill(CommandEngine(kShell), run.root() / "starts/first0", 0.2);
  run.Run(CommandEngine(kShell), "other");
  JobRun local;
  local.Run({}, "other");
  EXPECT_EQ(run.Results(), local.Results());
  EXPECT_EQ(NumStarts(run.root(), "first0"), 2u);
}

TEST(Jobs, ALocalRunTakesOverFromAKilledOneAndCleansUp) {
  JobRun run;
  AddHook(run.root(), "second3", "sleep 1");
  run.RunAndKill(CommandEngine(kShell), run.root() / "starts/second3", 0.1);
  run.Run({});
  EXPECT_EQ(run.Results(), LocalResults());
}

TEST(Jobs, AnInputThatChangesMeanwhileMakesTheResultVoid) {
  JobRun run;
  AddHook(run.root(), "first5", "change");
  run.Run(CommandEngine(kShell));
  JobRun local;
  WriteText(local.root() / "photo", "dusk");
  local.Run({});
  // Tasks that were done before the change are up to date with what they read; the next run sees.
  run.Run(CommandEngine(kShell));
  EXPECT_EQ(run.Results(), local.Results());
}

// Stops a run as Ctrl-C does once a task has started.
void RunAndCancel(JobRun* run, const std::string& task) {
  std::atomic<bool> cancel{false};
  std::thread stopper([&] {
    while (!fs::exists(run->root() / "starts" / task)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    cancel = true;
  });
  EXPECT_THROW(run->Run(CommandEngine(kShell), "word", &cancel), CancelledError);
  stopper.join();
}

TEST(Jobs, CancelEndsTheJobsOfTheRun) {
  JobRun run;
  AddHook(run.root(), "first2", "sleep 30");
  RunAndCancel(&run, "first2");
  EXPECT_GT(run.observer.num_jobs_at_end, 0u);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(NumStarts(run.root(), "first3"), 0u) << "the jobs went on";
  run.Run(CommandEngine(kShell));
  EXPECT_EQ(run.Results(), LocalResults());
}

TEST(Jobs, JobsThatAreToGoOnDoSo) {
  JobRun run;
  run.observer.keep_jobs = true;
  AddHook(run.root(), "first2", "sleep 1");
  RunAndCancel(&run, "first2");
  run.Run(CommandEngine(kShell));
  EXPECT_EQ(run.Results(), LocalResults());
  EXPECT_EQ(NumStarts(run.root(), "first2"), 1u);
}

TEST(JobNumber, IsABatchAndAJob) {
  EXPECT_EQ(ParseJobNumber("12.3").batch, "12");
  EXPECT_EQ(ParseJobNumber("12.3").slice, 3u);
  for (const char* text : {"", "12", "12.", ".3", "12.x", "12.3x"}) {
    EXPECT_THROW(ParseJobNumber(text), UsageError) << text;
  }
}

TEST(EngineOptions, CommandNeedsACommandWithJobs) {
  std::string error;
  EngineOptions options;
  EXPECT_TRUE(options.Check(&error));
  options.kind = EngineKind::kCommand;
  EXPECT_FALSE(options.Check(&error));
  options.submit_command = "parallel";
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THAT(error, HasSubstr("{commands}"));
  options.submit_command = "sh {commands}";
  EXPECT_TRUE(options.Check(&error));
}

// Tasks 0..n-1 in a row, each reading the files of its neighbours, in the order given.
std::vector<Task> RowOfTasks(const std::vector<int>& order) {
  std::vector<Task> tasks;
  for (const int i : order) {
    Task task;
    task.cost.cpu_seconds = 1;
    for (int n = i - 2; n <= i + 2; ++n) task.inputs.push_back("photo" + std::to_string(n));
    tasks.push_back(task);
  }
  return tasks;
}

// All of one length.
SliceLengths Lengths(double seconds) { return {.longest = seconds, .shortest = seconds}; }

TEST(TaskSlices, HoldTasksThatReadTheSameFiles) {
  const std::vector<Task> tasks = RowOfTasks({0, 10, 1, 11, 2, 12, 3, 13});
  const std::vector<size_t> all = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto slices = SliceTasks(tasks, all, Lengths(4), 8);
  ASSERT_EQ(slices.size(), 2u);
  EXPECT_THAT(slices[0], testing::ElementsAre(0, 2, 4, 6));
  EXPECT_THAT(slices[1], testing::ElementsAre(1, 3, 5, 7));
}

TEST(TaskSlices, HaveAtLeastOneTaskAndNoMoreThanTheTime) {
  const std::vector<Task> tasks = RowOfTasks({0, 1, 2, 3, 4});
  const std::vector<size_t> all = {0, 1, 2, 3, 4};
  EXPECT_EQ(SliceTasks(tasks, all, Lengths(0), 5).size(), 5u);
  EXPECT_EQ(SliceTasks(tasks, all, Lengths(2.5), 5).size(), 3u);
  EXPECT_EQ(SliceTasks(tasks, all, Lengths(100), 5).size(), 1u);
}

TEST(TaskSlices, GetShorterTowardsTheEnd) {
  std::vector<int> order(100);
  std::iota(order.begin(), order.end(), 0);
  const std::vector<Task> tasks = RowOfTasks(order);
  std::vector<size_t> all(100);
  std::iota(all.begin(), all.end(), size_t{0});
  const SliceLengths lengths{.longest = 20, .shortest = 5, .jobs_at_once = 2};
  std::vector<size_t> sizes;
  for (const auto& slice : SliceTasks(tasks, all, lengths, 100)) sizes.push_back(slice.size());
  EXPECT_THAT(sizes, testing::ElementsAre(20, 20, 15, 11, 8, 6, 5, 5, 5, 5));
  EXPECT_EQ(SliceTasks(tasks, all, lengths, 100, 3).size(), 3u);
}

TEST(TaskSlices, KeepAllMachinesBusyWhereThereIsLittleToDo) {
  const EngineOptions options;
  // Nine seconds on two machines: two jobs. A thousand: no job below a twentieth of a machine's
  // part.
  EXPECT_DOUBLE_EQ(LengthsOfJobs(9, 1, 2, options).shortest, 4.5);
  EXPECT_DOUBLE_EQ(LengthsOfJobs(1000, 1, 2, options).shortest, 25);
  EXPECT_DOUBLE_EQ(LengthsOfJobs(1000, 1, 2, options).longest, 300);
  EXPECT_DOUBLE_EQ(LengthsOfJobs(4000, 4, 2, options).shortest, 100);
}

TEST(ReadyTasks, AreThoseWhoseInputsAreThere) {
  JobRun run;
  const std::vector<Task> tasks = MakeJobTasks(run.root(), "word");
  std::vector<size_t> all(tasks.size());
  std::iota(all.begin(), all.end(), size_t{0});
  ReadyTasks ready(tasks, all);
  EXPECT_THAT(ready.ready(), testing::ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(ready.NumBlocked(), 7u);
  while (!ready.ready().empty()) {
    const size_t next = *ready.ready().begin();
    ready.Take(next);
    EXPECT_FALSE(ready.ready().contains(next));
    ready.OnDone(next);
  }
  EXPECT_EQ(ready.NumBlocked(), 0u);
  EXPECT_NEAR(ready.seconds_left(), 0, 1e-9);
}

TEST(TaskSlices, RoundsFollowFiles) {
  JobRun run;
  const std::vector<Task> tasks = MakeJobTasks(run.root(), "word");
  std::vector<size_t> all;
  for (size_t i = 0; i < tasks.size(); ++i) all.push_back(i);
  const auto rounds = RoundsOf(tasks, all);
  ASSERT_EQ(rounds.size(), 3u);
  EXPECT_EQ(rounds[0].size(), 6u);
  EXPECT_EQ(rounds[1].size(), 6u);
  EXPECT_EQ(rounds[2].size(), 1u);
}

}  // namespace
}  // namespace lsmvs
