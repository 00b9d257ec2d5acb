#include "job_run.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "job_tasks.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/test_support/test_data.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {
void SleepSeconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}
}  // namespace

std::string NotingObserver::Notes() const {
  std::string text;
  for (const std::string& note : notes) text += note + "\n";
  return text;
}

JobRun::JobRun() { WriteText(root() / "photo", "light"); }

void JobRun::Run(const EngineOptions& options, const std::string& word,
                 const std::atomic<bool>* cancel) {
  observer.notes.clear();
  const std::vector<Task> tasks = MakeJobTasks(root(), word);
  RunStore store(root(), "test 1");
  PlanOptions plan_options;
  plan_options.scratch_folder = root() / "lsmvs";
  const RunPlan plan = PlanRun(tasks, plan_options, &store);
  RunContext context(1);
  context.cancel = cancel;
  std::unique_ptr<Engine> engine = MakeLocalEngine();
  if (options.kind != EngineKind::kLocal) {
    const DriverCommand command{(ProgramFolder() / "job_worker").string(), "test", {word}};
    engine = MakeJobEngine(root(), options, command, {1, 1}, {});
  }
  RunTasks(tasks, plan, &store, &observer, context, engine.get());
}

void JobRun::RunAndKill(const EngineOptions& options, const fs::path& file, double seconds) {
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      Run(options);
      ::_exit(0);
    } catch (...) {
      ::_exit(1);
    }
  }
  const auto has_ended = [child] { return ::waitpid(child, nullptr, WNOHANG) != 0; };
  bool ended = false;
  while (!fs::exists(file) && !(ended = has_ended())) SleepSeconds(0.01);
  if (ended) return;
  SleepSeconds(seconds);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

std::map<std::string, std::string> JobRun::Results() const {
  std::map<std::string, std::string> results;
  for (const auto& entry : fs::recursive_directory_iterator(root())) {
    const std::string name = fs::relative(entry.path(), root()).string();
    const bool serves_run =
        name == "lsmvs/run.json" || name.starts_with("starts") || name.starts_with("hooks");
    if (entry.is_regular_file() && !serves_run) results[name] = ReadText(entry.path());
  }
  return results;
}

const std::map<std::string, std::string>& LocalResults() {
  static const std::map<std::string, std::string> results = [] {
    JobRun run;
    run.Run({});
    return run.Results();
  }();
  return results;
}

EngineOptions CommandEngine(const std::string& command) {
  EngineOptions options;
  options.kind = EngineKind::kCommand;
  options.job_minutes = 0;
  options.submit_command = command;
  return options;
}

}  // namespace lsmvs
