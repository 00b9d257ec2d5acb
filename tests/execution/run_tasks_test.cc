#include "lsmvs/execution/run_tasks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"
#include "text_tasks.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// photo -> a (two files) -> b -> c, each a stage.
class Chain : public testing::Test {
 protected:
  Chain() { WriteText(root() / "photo", "light"); }

  const std::filesystem::path& root() const { return folder_.path(); }

  std::vector<Task> Tasks() {
    std::vector<Task> tasks = {
        TextTask("a", {root() / "photo"}, {root() / "a1", root() / "sub/a2"}, &calls_[0]),
        TextTask("b", {root() / "a1", root() / "sub/a2"}, {root() / "b"}, &calls_[1]),
        TextTask("c", {root() / "b"}, {root() / "c"}, &calls_[2])};
    tasks[0].wanted = false;
    tasks[0].foreign_outputs = tasks[1].foreign_outputs = ForeignOutputs::kUse;
    return tasks;
  }

  // Runs and returns how often each task was called.
  std::vector<int> Run(const std::vector<Task>& tasks, bool overwrite = false) {
    calls_ = {0, 0, 0};
    RunStore store(root(), "test 1");
    observer_ = {};
    PlanOptions options;
    options.overwrite = overwrite;
    const RunPlan plan = PlanRun(tasks, options, &store);
    RunTasks(tasks, plan, &store, &observer_, RunContext(1));
    return {calls_.begin(), calls_.end()};
  }
  std::vector<int> Run() { return Run(Tasks()); }

  std::string Result() const { return ReadText(root() / "c"); }

  TemporaryFolder folder_;
  std::array<int, 3> calls_ = {};
  SilentObserver observer_;
};

constexpr const char* kExpected = "c(b(a(light)#0a(light)#1)#0)#0";

// A task that writes as many files more as `*count` says.
Task GrowingTask(const std::filesystem::path& root, const int* count, int* calls) {
  Task task = TextTask("g", {root / "photo"}, {root / "g0"}, calls);
  task.run = [=, first = task.run](const TaskRun& run) {
    for (int i = 1; i <= *count; ++i) {
      WriteText(run.add_output(root / ("g" + std::to_string(i))), std::to_string(i));
    }
    return first(run);
  };
  return task;
}

TEST_F(Chain, TasksMayAddOutputs) {
  int count = 2;
  const std::vector<Task> tasks = {GrowingTask(root(), &count, &calls_[0])};
  EXPECT_THAT(Run(tasks), ElementsAre(1, 0, 0));
  EXPECT_EQ(ReadText(root() / "g2"), "2");
  EXPECT_THAT(Run(tasks), ElementsAre(0, 0, 0));
  std::filesystem::remove(root() / "g2");
  EXPECT_THAT(Run(tasks), ElementsAre(1, 0, 0));
  EXPECT_EQ(ReadText(root() / "g2"), "2");
  // What it does not write any more goes.
  count = 1;
  std::filesystem::remove(root() / "g0");
  EXPECT_THAT(Run(tasks), ElementsAre(1, 0, 0));
  EXPECT_TRUE(std::filesystem::exists(root() / "g1"));
  EXPECT_FALSE(std::filesystem::exists(root() / "g2"));
  // Files of others stay.
  count = 2;
  WriteText(root() / "g2", "mine");
  std::filesystem::remove(root() / "g0");
  EXPECT_THROW(Run(tasks), Error);
  EXPECT_EQ(ReadText(root() / "g2"), "mine");
  EXPECT_EQ(ReadText(root() / "g1"), "1");
  EXPECT_FALSE(std::filesystem::exists(root() / "lsmvs/staging"));
  EXPECT_THAT(Run(tasks, true), ElementsAre(1, 0, 0));
  EXPECT_EQ(ReadText(root() / "g2"), "2");
}

TEST_F(Chain, RunsInOrderAndThenNotAgain) {
  EXPECT_THAT(Run(), ElementsAre(1, 1, 1));
  EXPECT_EQ(Result(), kExpected);
  EXPECT_THAT(observer_.begun, ElementsAre("a", "b", "c"));
  EXPECT_EQ(observer_.ended[0].counts.at("files"), 2);
  EXPECT_THAT(Run(), ElementsAre(0, 0, 0));
  EXPECT_TRUE(observer_.begun.empty());
  EXPECT_FALSE(std::filesystem::exists(root() / "lsmvs/staging"));
}

TEST_F(Chain, ChangedInputRunsWhatDependsOnIt) {
  Run();
  WriteText(root() / "photo", "dark");
  EXPECT_THAT(Run(), ElementsAre(1, 1, 1));
  EXPECT_EQ(Result(), "c(b(a(dark)#0a(dark)#1)#0)#0");
}

TEST_F(Chain, TouchedInputOfTheSameBytesRunsNothing) {
  Run();
  WriteText(root() / "photo", "light");
  EXPECT_THAT(Run(), ElementsAre(0, 0, 0));
}

TEST_F(Chain, ChangedOptionsOrVersionRunTheTaskAndWhatFollows) {
  Run();
  std::vector<Task> tasks = Tasks();
  tasks[1].options = "word=b\nmore=1\n";
  EXPECT_THAT(Run(tasks), ElementsAre(0, 1, 0));  // b gives the same bytes: c is skipped after all
  tasks[2].version = "2";
  EXPECT_THAT(Run(tasks), ElementsAre(0, 0, 1));
  EXPECT_THAT(Run(tasks), ElementsAre(0, 0, 0));
}

TEST_F(Chain, DeletedIntermediateFilesAreNotMissed) {
  Run();
  std::filesystem::remove(root() / "a1");
  EXPECT_THAT(Run(), ElementsAre(0, 0, 0));
  std::filesystem::remove(root() / "c");
  EXPECT_THAT(Run(), ElementsAre(0, 0, 1));
  std::filesystem::remove(root() / "b");
  EXPECT_THAT(Run(), ElementsAre(1, 1, 0));
  EXPECT_EQ(Result(), kExpected);
}

TEST_F(Chain, ForeignIntermediateIsUsedAndWhatLeadsToItIsLeftOut) {
  WriteText(root() / "b", "theirs");
  EXPECT_THAT(Run(), ElementsAre(0, 0, 1));
  EXPECT_EQ(Result(), "c(theirs)#0");
  EXPECT_EQ(ReadText(root() / "b"), "theirs");
  EXPECT_THAT(Run(), ElementsAre(0, 0, 0));
  EXPECT_THAT(Run(Tasks(), true), ElementsAre(1, 1, 1));
  EXPECT_EQ(Result(), kExpected);
}

TEST_F(Chain, ChangedResultOfOursCountsAsForeign) {
  Run();
  WriteText(root() / "b", "edited");
  EXPECT_THAT(Run(), ElementsAre(0, 0, 1));
  EXPECT_EQ(Result(), "c(edited)#0");
}

TEST_F(Chain, AnotherTaskOfTheSameResultReplacesItAndBack) {
  Run();
  std::vector<Task> other = Tasks();
  other[1] = TextTask("other", {root() / "photo"}, {root() / "b"}, &calls_[1]);
  EXPECT_THAT(Run(other), ElementsAre(0, 1, 1));
  EXPECT_EQ(Result(), "c(other(light)#0)#0");
  EXPECT_THAT(Run(other), ElementsAre(0, 0, 0));
  EXPECT_THAT(Run(), ElementsAre(0, 1, 1));
  EXPECT_EQ(Result(), kExpected);
  std::filesystem::remove(root() / "b");
  std::filesystem::remove(root() / "c");
  EXPECT_THAT(Run(other), ElementsAre(0, 1, 1));
  EXPECT_EQ(Result(), "c(other(light)#0)#0");
}

TEST_F(Chain, ForeignResultIsRefused) {
  WriteText(root() / "c", "theirs");
  try {
    Run();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kOverwrite);
    EXPECT_THAT(error.what(), HasSubstr((root() / "c").string()));
  }
  EXPECT_EQ(ReadText(root() / "c"), "theirs");
  EXPECT_THAT(Run(Tasks(), true), ElementsAre(1, 1, 1));
  EXPECT_EQ(Result(), kExpected);
}

TEST_F(Chain, HalfAForeignResultIsRefused) {
  WriteText(root() / "a1", "theirs");
  EXPECT_THROW(Run(), Error);
  WriteText(root() / "sub/a2", "theirs");
  EXPECT_THAT(Run(), ElementsAre(0, 1, 1));
}

TEST_F(Chain, MissingInputIsNamed) {
  std::filesystem::remove(root() / "photo");
  EXPECT_THROW(Run(), InputError);
}

TEST_F(Chain, AFailedTaskLeavesNothingOfItsOwnAndKeepsWhatWasBefore) {
  std::vector<Task> tasks = Tasks();
  tasks[1].run = [](const TaskRun& run) -> TaskCounts {
    WriteText(run.outputs[0], "half");
    throw InputError("x", "broken", "mend it");
  };
  EXPECT_THROW(Run(tasks), InputError);
  EXPECT_FALSE(std::filesystem::exists(root() / "b"));
  EXPECT_FALSE(std::filesystem::exists(root() / "lsmvs/staging"));
  EXPECT_THAT(Run(), ElementsAre(0, 1, 1));
}

TEST_F(Chain, CancelKeepsFinishedTasks) {
  std::atomic<bool> cancel{false};
  std::vector<Task> tasks = Tasks();
  const auto run_b = tasks[1].run;
  tasks[1].run = [&](const TaskRun& run) {
    cancel = true;
    return run_b(run);
  };
  RunContext context(1);
  context.cancel = &cancel;
  {
    RunStore store(root(), "test 1");
    const RunPlan plan = PlanRun(tasks, {}, &store);
    EXPECT_THROW(RunTasks(tasks, plan, &store, &observer_, context), CancelledError);
  }
  EXPECT_THAT(Run(), ElementsAre(0, 0, 1));
}

TEST_F(Chain, AMovedFolderStaysUpToDate) {
  Run();
  const TemporaryFolder other;
  const std::filesystem::path moved = other.path() / "moved";
  std::filesystem::copy(root(), moved, std::filesystem::copy_options::recursive);
  std::vector<Task> tasks = {TextTask("a", {moved / "photo"}, {moved / "a1", moved / "sub/a2"})};
  RunStore store(moved, "test 1");
  EXPECT_EQ(PlanRun(tasks, {}, &store).NumToRun(), 0u);
}

TEST_F(Chain, OutputsOutsideTheRootArePublishedToo) {
  const TemporaryFolder other;
  const std::vector<Task> tasks = {TextTask("x", {root() / "photo"}, {other.path() / "out"})};
  Run(tasks);
  EXPECT_EQ(ReadText(other.path() / "out"), "x(light)#0");
  EXPECT_FALSE(std::filesystem::exists(other.path() / ".lsmvs-staging"));
}

TEST_F(Chain, PlanGivesReasonsAndCosts) {
  std::vector<Task> tasks = Tasks();
  tasks[0].cost = {10, 100};
  tasks[1].cost = {20, 300};
  tasks[2].cost = {30, 200};
  RunStore store(root(), "test 1");
  const RunPlan plan = PlanRun(tasks, {}, &store);
  ASSERT_EQ(plan.stages.size(), 3u);
  EXPECT_EQ(plan.stages[0].reason, "new");
  EXPECT_EQ(plan.Cost().cpu_seconds, 60);
  EXPECT_EQ(plan.Cost().peak_bytes, 300u);
  EXPECT_EQ(plan.NumToRun(), 3u);
}

TEST_F(Chain, ASecondRunInTheSameFolderIsKeptOut) {
  RunStore store(root(), "test 1");
  EXPECT_THROW(RunStore(root(), "test 1"), Error);
}

// photo -> first of each of three views (temporary) -> second of each, which reads its own and the
// next view's first -> end.
class TwoPasses : public testing::Test {
 protected:
  static constexpr int kNumViews = 3;
  static constexpr uint64_t kBytes = 1000;

  TwoPasses() { WriteText(root() / "photo", "light"); }
  const std::filesystem::path& root() const { return folder_.path(); }
  std::filesystem::path First(int v) const { return root() / ("first" + std::to_string(v)); }
  std::filesystem::path Second(int v) const { return root() / ("second" + std::to_string(v)); }

  std::vector<Task> Tasks(bool temporary = true) {
    std::vector<Task> tasks;
    for (int v = 0; v < kNumViews; ++v) {
      tasks.push_back(TextTask("first" + std::to_string(v), {root() / "photo"}, {First(v)}));
      tasks.back().temporary = temporary;
    }
    for (int v = 0; v < kNumViews; ++v) {
      tasks.push_back(TextTask("second" + std::to_string(v),
                               {First(v), First(std::min(v + 1, kNumViews - 1))}, {Second(v)}));
    }
    tasks.push_back(TextTask("end", {Second(0), Second(1), Second(2)}, {root() / "end"}));
    for (Task& task : tasks) {
      task.wanted = task.name == "end";
      task.output_bytes = kBytes;
      task.foreign_outputs = ForeignOutputs::kUse;
    }
    return tasks;
  }

  // Number of tasks that ran.
  size_t Run(const std::vector<Task>& tasks) {
    RunStore store(root(), "test 1");
    const RunPlan plan = PlanRun(tasks, {}, &store);
    size_t num_ran = 0;
    for (const StageSummary& summary : RunTasks(tasks, plan, &store, &observer_, RunContext(1))) {
      num_ran += summary.num_ran;
    }
    return num_ran;
  }
  int NumFirst() const {
    int count = 0;
    for (int v = 0; v < kNumViews; ++v) count += std::filesystem::exists(First(v));
    return count;
  }

  TemporaryFolder folder_;
  SilentObserver observer_;
};

TEST_F(TwoPasses, TemporaryOutputsGoWhenTheirLastReaderIsDone) {
  std::vector<Task> tasks = Tasks();
  std::vector<int> there;
  for (int v = 0; v < kNumViews; ++v) {
    Task& second = tasks[static_cast<size_t>(kNumViews + v)];
    second.run = [&, run = second.run](const TaskRun& context) {
      there.push_back(NumFirst());
      return run(context);
    };
  }
  EXPECT_EQ(Run(tasks), tasks.size());
  EXPECT_THAT(there, ElementsAre(3, 2, 1));
  EXPECT_EQ(NumFirst(), 0);
  // Nobody misses them.
  EXPECT_EQ(Run(Tasks()), 0u);
  std::filesystem::remove(root() / "end");
  EXPECT_EQ(Run(Tasks()), 1u);
  // Where one is needed again it is made again, and only then.
  std::filesystem::remove(Second(2));
  std::filesystem::remove(root() / "end");
  EXPECT_EQ(Run(Tasks()), 3u);
  EXPECT_EQ(NumFirst(), 0);
}

TEST_F(TwoPasses, WhatIsToBeKeptStays) {
  EXPECT_GT(Run(Tasks(false)), 0u);
  EXPECT_EQ(NumFirst(), kNumViews);
  // Also in later runs that would not keep it.
  EXPECT_EQ(Run(Tasks(true)), 0u);
  EXPECT_EQ(NumFirst(), kNumViews);
}

TEST_F(TwoPasses, FilesOfOthersAreNeverRemoved) {
  WriteText(First(1), "theirs");
  Run(Tasks());
  EXPECT_EQ(ReadText(First(1)), "theirs");
  EXPECT_EQ(NumFirst(), 1);
}

// A run that is stopped in between: the next one ends the removal.
TEST_F(TwoPasses, LeftoversOfAStoppedRunAreRemoved) {
  std::vector<Task> tasks = Tasks();
  tasks.back().run = [](const TaskRun&) -> TaskCounts { throw InputError("x", "y", "z"); };
  EXPECT_THROW(Run(tasks), InputError);
  EXPECT_EQ(NumFirst(), 0);
  // As if it had been killed before the removal.
  const TemporaryFolder other;
  std::vector<Task> kept = Tasks();
  EXPECT_EQ(Run(kept), 1u);
  for (int v = 0; v < kNumViews; ++v) std::filesystem::remove(Second(v));
  std::filesystem::remove(root() / "end");
  kept = Tasks();
  kept[5].run = [](const TaskRun&) -> TaskCounts { throw InputError("x", "y", "z"); };
  EXPECT_THROW(Run(kept), InputError);
  EXPECT_EQ(NumFirst(), 1);  // that the last one still has to read
  EXPECT_GT(Run(Tasks()), 0u);
  EXPECT_EQ(NumFirst(), 0);
}

TEST_F(TwoPasses, DiskIsCountedAtItsMost) {
  RunStore store(root(), "test 1");
  // Three of the first pass and one of the second; each further one replaces one of the first, the
  // end two.
  EXPECT_EQ(PlanRun(Tasks(), {}, &store).peak_disk_bytes, 4 * kBytes);
  EXPECT_EQ(PlanRun(Tasks(false), {}, &store).peak_disk_bytes, 7 * kBytes);
  const RunPlan plan = PlanRun(Tasks(), {}, &store);
  EXPECT_EQ(plan.stages.back().output_bytes, kBytes);
}

// A task that needs 1,000 bytes, or 100 with a scratch file.
Task LargeTask(const std::filesystem::path& folder) {
  Task task;
  task.stage = task.name = "large";
  task.outputs = {folder / "large"};
  task.cost.peak_bytes = 1000;
  task.least_bytes = 100;
  return task;
}

PlannedTask PlanLarge(const Task& task, size_t memory_bytes, int num_parts, RunStore* store) {
  PlanOptions options;
  options.memory_bytes = memory_bytes;
  options.num_parts = num_parts;
  return PlanRun({task}, options, store).tasks.at(0);
}

TEST(ScratchPlan, TasksThatDoNotFitGetAScratchFile) {
  const TemporaryFolder folder;
  RunStore store(folder.path(), "test 1");
  const Task task = LargeTask(folder.path());
  EXPECT_EQ(PlanLarge(task, 1000, 1, &store).resident_bytes, 0u);
  EXPECT_EQ(PlanLarge(task, 999, 1, &store).resident_bytes, 999u);
  EXPECT_EQ(PlanLarge(task, 1000, 4, &store).resident_bytes, 250u);
  EXPECT_EQ(PlanLarge(task, 200, 4, &store).resident_bytes, 200u);
  EXPECT_EQ(PlanLarge(task, 50, 4, &store).resident_bytes, 100u);  // more than there is: refused
  Task unable = task;
  unable.least_bytes = 0;
  EXPECT_EQ(PlanLarge(unable, 999, 4, &store).resident_bytes, 0u);
}

TEST(ScratchPlan, StagesCountWhatStaysInMemoryAndTheFile) {
  const TemporaryFolder folder;
  RunStore store(folder.path(), "test 1");
  PlanOptions options;
  options.num_parts = 4;
  options.scratch_folder = folder.path();
  const RunPlan plan = PlanRun({LargeTask(folder.path())}, options, &store);
  EXPECT_EQ(plan.stages.at(0).cost.peak_bytes, 250u);
  EXPECT_EQ(plan.stages.at(0).scratch_bytes, 1000u);
  EXPECT_EQ(plan.peak_scratch_bytes, 1000u);
  EXPECT_EQ(plan.scratch_folder, folder.path());
}

TEST(ScratchPlan, CheckpointsAreCountedWithTheScratchFile) {
  const TemporaryFolder folder;
  RunStore store(folder.path(), "test 1");
  PlanOptions options;
  options.num_parts = 4;
  Task task = LargeTask(folder.path());
  task.checkpoint_bytes = 70;
  EXPECT_EQ(PlanRun({task}, options, &store).peak_scratch_bytes, 1070u);
  EXPECT_EQ(PlanRun({task}, {}, &store).peak_scratch_bytes, 0u);
}

// This program has no scratch memory: a task is given no folder for its steps, and folders of
// others stay. The end-to-end tests kill divided runs.
TEST(ScratchPlan, OthersCheckpointsStay) {
  const TemporaryFolder folder;
  const auto theirs = folder.path() / "lsmvs-steps-of-others" / "step";
  WriteText(theirs, "theirs");
  RunStore store(folder.path() / "root", "test 1");
  Task task = LargeTask(folder.path());
  task.checkpoint_bytes = 1;
  task.run = [&](const TaskRun& run) {
    EXPECT_TRUE(run.checkpoint_folder.empty());
    WriteText(run.outputs.at(0), "result");
    return TaskCounts();
  };
  PlanOptions options;
  options.scratch_folder = folder.path();
  SilentObserver observer;
  const RunPlan plan = PlanRun({task}, options, &store);
  RunTasks({task}, plan, &store, &observer, RunContext(1));
  EXPECT_EQ(ReadText(theirs), "theirs");
}

// Costs are measured where a task runs and reads what is there.
TEST_F(Chain, CostsAreMeasuredOfTasksThatRunOnWhatIsThere) {
  std::vector<Task> tasks = Tasks();
  std::vector<int> calls(tasks.size(), 0);
  for (size_t i = 0; i < tasks.size(); ++i) {
    tasks[i].measure_cost = [&calls, i](Task* task) {
      ++calls[i];
      task->cost.peak_bytes = 4711;
    };
  }
  {
    RunStore store(root(), "test 1");
    EXPECT_TRUE(MeasureCosts(PlanRun(tasks, {}, &store), &tasks));
    EXPECT_EQ(calls.front(), 1);
    EXPECT_EQ(calls.back(), 0);  // reads what is still to be made
    EXPECT_EQ(tasks.front().cost.peak_bytes, 4711u);
  }
  Run();
  RunStore store(root(), "test 1");
  EXPECT_FALSE(MeasureCosts(PlanRun(tasks, {}, &store), &tasks));  // all is up to date
}

// This program has no scratch memory: the refusal stays what it is.
TEST(ScratchPlan, WithoutScratchMemoryARefusalIsPassedOn) {
  const TemporaryFolder folder;
  RunStore store(folder.path(), "test 1");
  Task task = LargeTask(folder.path());
  int calls = 0;
  task.run = [&](const TaskRun&) -> TaskCounts {
    ++calls;
    throw MemoryError("too large");
  };
  SilentObserver observer;
  const RunPlan plan = PlanRun({task}, {}, &store);
  EXPECT_THROW(RunTasks({task}, plan, &store, &observer, RunContext(1)), MemoryError);
  EXPECT_EQ(calls, 1);
}

TEST_F(Chain, ReplacedFilesMakeRoomOnlyWhenTheNewOnesAreComplete) {
  Run();
  std::vector<Task> tasks = Tasks();
  for (Task& task : tasks) {
    task.version = "2";
    task.output_bytes = 1000;
  }
  RunStore store(root(), "test 1");
  const RunPlan plan = PlanRun(tasks, {}, &store);
  EXPECT_LE(plan.peak_disk_bytes, 3000u);
  EXPECT_GT(plan.peak_disk_bytes, 3000u - 200u);  // the old files are small
  EXPECT_TRUE(plan.leftovers.empty());
}

// Eight tasks of one stage; the parts of the stage's progress.
TEST(Stage, ResumesInTheMiddleAndReportsProgress) {
  const TemporaryFolder folder;
  WriteText(folder.path() / "photo", "light");
  int calls = 0;
  std::vector<Task> tasks;
  for (int i = 0; i < 8; ++i) {
    tasks.push_back(TextTask("view" + std::to_string(i), {folder.path() / "photo"},
                             {folder.path() / ("out" + std::to_string(i))}, &calls));
    tasks.back().stage = "stereo";
  }
  RunStore store(folder.path(), "test 1");
  SilentObserver observer;
  const std::vector<Task> first(tasks.begin(), tasks.begin() + 6);
  RunTasks(first, PlanRun(first, {}, &store), &store, &observer, RunContext(1));
  EXPECT_EQ(calls, 6);
  const RunPlan plan = PlanRun(tasks, {}, &store);
  EXPECT_EQ(plan.stages.at(0).num_up_to_date, 6u);
  struct Sink : ProgressSink {
    void Report(double fraction) override { fractions.push_back(fraction); }
    std::vector<double> fractions;
  } sink;
  RunContext context(1);
  context.set_progress(&sink);
  RunTasks(tasks, plan, &store, &observer, context);
  EXPECT_EQ(calls, 8);
  EXPECT_DOUBLE_EQ(observer.done_before.back(), 0.75);
  EXPECT_THAT(sink.fractions, ElementsAre(testing::DoubleEq(0.875), testing::DoubleEq(1.0)));
}

}  // namespace
}  // namespace lsmvs
