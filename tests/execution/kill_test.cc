#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <random>
#include <thread>

#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "text_tasks.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// Two passes over six views, each output a pair of files, then one that takes all: what a
// reconstruction looks like to the runner.
std::vector<Task> MakeTasks(const fs::path& root) {
  std::vector<Task> tasks;
  std::vector<fs::path> last = {root / "photo"};
  for (const std::string pass : {"first", "second"}) {
    std::vector<fs::path> outputs;
    for (int i = 0; i < 6; ++i) {
      const fs::path base = root / "maps" / (pass + std::to_string(i));
      tasks.push_back(
          TextTask(base.filename(), last, {base.string() + ".d", base.string() + ".n"}));
      tasks.back().stage = pass;
      outputs.insert(outputs.end(), tasks.back().outputs.begin(), tasks.back().outputs.end());
    }
    last = outputs;
  }
  tasks.push_back(TextTask("all", last, {root / "all", root / "all.vis"}));
  return tasks;
}

void RunAll(const fs::path& root) {
  const std::vector<Task> tasks = MakeTasks(root);
  RunStore store(root, "test 1");
  SilentObserver observer;
  RunTasks(tasks, PlanRun(tasks, {}, &store), &store, &observer, RunContext(1));
}

// Runs in a child process that is killed after `microseconds`. Whether it ended by itself.
bool RunAndKill(const fs::path& root, int64_t microseconds) {
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      RunAll(root);
      ::_exit(0);
    } catch (...) {
      ::_exit(1);
    }
  }
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status)) {
    EXPECT_EQ(WEXITSTATUS(status), 0) << "a restart failed";
  }
  return WIFEXITED(status);
}

// How long an undisturbed run takes here and now.
int64_t RunMicroseconds(const fs::path& root) {
  const auto begin = std::chrono::steady_clock::now();
  RunAll(root);
  const auto duration = std::chrono::steady_clock::now() - begin;
  return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

// All files but the record, whose times differ.
std::map<std::string, std::string> Results(const fs::path& root) {
  std::map<std::string, std::string> results;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string name = fs::relative(entry.path(), root).string();
    if (entry.is_regular_file() && name != "lsmvs/run.json") results[name] = ReadText(entry.path());
  }
  return results;
}

TEST(Kill, AnyNumberOfKillsEndsWithTheSameFiles) {
  constexpr int kNumKills = 15, kMaxRuns = 5000;
  const TemporaryFolder undisturbed;
  WriteText(undisturbed.path() / "photo", "light");
  const int64_t run_microseconds = RunMicroseconds(undisturbed.path());
  const auto expected = Results(undisturbed.path());
  std::mt19937 random(7);
  int num_kills = 0, num_runs = 0;
  // A machine with much else to do lets most runs end before they are killed: then once more.
  while (num_kills < kNumKills) {
    const TemporaryFolder killed;
    WriteText(killed.path() / "photo", "light");
    std::uniform_int_distribution<int64_t> moment(0, run_microseconds);
    while (!RunAndKill(killed.path(), moment(random))) {
      ++num_kills;
      ASSERT_LT(++num_runs, kMaxRuns);
    }
    ASSERT_LT(++num_runs, kMaxRuns);
    RunAll(killed.path());
    EXPECT_EQ(Results(killed.path()), expected);
  }
}

}  // namespace
}  // namespace lsmvs
