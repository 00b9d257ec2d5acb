// bookkeeping FOLDER [number of tasks, 10000]: what keeping the books of a run costs beside its
// work: tasks of two small files each, each reading ten files, as a run of thousands of photos has
// them. Prints the CPU seconds of the plan, of the run, and of a second plan that finds all up to
// date.

#include <fmt/format.h>
#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

class SilentObserver : public RunObserver {
 public:
  void OnStageBegin(const PlannedStage&, double) override {}
  void OnStageEnd(const StageSummary&) override {}
};

double CpuSeconds() {
  rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::vector<Task> MakeTasks(const fs::path& root, size_t num_tasks) {
  constexpr size_t kInputs = 10;
  std::vector<Task> tasks(num_tasks);
  for (size_t i = 0; i < num_tasks; ++i) {
    Task& task = tasks[i];
    task.stage = "stage";
    task.name = fmt::format("stage/{:06}", i);
    task.version = "1";
    for (int option = 0; option < 30; ++option) {
      task.options += fmt::format("Group.option_number_{}=0.5\n", option);
    }
    for (size_t k = 0; k < kInputs; ++k) {
      task.inputs.push_back(root / fmt::format("photos/{:06}", (i + k) % num_tasks));
    }
    const std::string base = (root / fmt::format("maps/{:06}", i)).string();
    task.outputs = {base + ".depth", base + ".normal"};
    task.run = [i](const TaskRun& run) {
      for (const fs::path& output : run.outputs) std::ofstream(output) << i;
      return TaskCounts{{"maps", 1.0}};
    };
  }
  return tasks;
}

void Measure(const fs::path& root, size_t num_tasks) {
  fs::create_directories(root / "photos");
  for (size_t i = 0; i < num_tasks; ++i) {
    std::ofstream(root / fmt::format("photos/{:06}", i)) << i;
  }
  const std::vector<Task> tasks = MakeTasks(root, num_tasks);
  SilentObserver observer;
  double begin = CpuSeconds();
  const auto lap = [&begin] { return CpuSeconds() - std::exchange(begin, CpuSeconds()); };
  double plan_seconds = 0, run_seconds = 0;
  {
    RunStore store(root, "bench");
    const RunPlan plan = PlanRun(tasks, {}, &store);
    plan_seconds = lap();
    RunTasks(tasks, plan, &store, &observer, RunContext(1));
    run_seconds = lap();
  }
  lap();
  RunStore store(root, "bench");
  const size_t num_to_run = PlanRun(tasks, {}, &store).NumToRun();
  fmt::print(
      "{} tasks: plan {:.2f} s, run {:.2f} s ({:.2f} ms a task), plan again {:.2f} s ({} to "
      "run); run.json {}, {} of memory\n",
      num_tasks, plan_seconds, run_seconds, 1e3 * run_seconds / static_cast<double>(num_tasks),
      lap(), num_to_run, FormatBytes(fs::file_size(root / "lsmvs/run.json")),
      FormatBytes(PeakResidentBytes()));
}

}  // namespace
}  // namespace lsmvs

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  lsmvs::Measure(argv[1], argc > 2 ? static_cast<size_t>(std::atol(argv[2])) : 10000);
}
