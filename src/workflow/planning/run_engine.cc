#include "lsmvs/workflow/planning/run_engine.h"

#include <fmt/format.h>

#include <algorithm>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr int kMaxSharedThreads = 4, kMaxThreadsAlone = 16;
constexpr double kNodeMemoryShare = 0.95;

JobThreads ThreadsOfJobs(const EngineOptions& options, const std::optional<JobLimits>& limits,
                         const CommandContext& context) {
  const int given = context.run.num_threads();
  if (context.has_num_threads) return {given, given};
  if (options.kind == EngineKind::kCommand) return {1, given};
  const int largest = limits ? limits->num_threads : kMaxSharedThreads;
  return {std::min(kMaxSharedThreads, largest), std::min(kMaxThreadsAlone, largest)};
}

size_t MemoryOfJobs(const std::optional<JobLimits>& limits, const CommandContext& context) {
  if (context.has_max_memory || !limits || limits->memory_bytes == 0) return context.AllowedBytes();
  return static_cast<size_t>(kNodeMemoryShare * static_cast<double>(limits->memory_bytes));
}

}  // namespace

RunResources FindResources(const EngineOptions& options, const CommandContext& context) {
  const int own_threads = context.run.num_threads();
  if (options.kind == EngineKind::kLocal || context.job) {
    return {context, {own_threads, own_threads}};
  }
  std::string error;
  if (!options.Check(&error)) throw UsageError(error);
  const std::optional<JobLimits> limits = FindJobLimits(options);
  const JobThreads threads = ThreadsOfJobs(options, limits, context);
  RunContext run(std::max(threads.shared, threads.alone));
  run.seed = context.run.seed;
  run.cancel = context.run.cancel;
  run.set_progress(context.run.progress());
  const size_t memory = MemoryOfJobs(limits, context);
  run.memory_budget_bytes = memory - std::min(memory, context.process_bytes);
  CommandContext of_jobs = context;
  of_jobs.run = run;
  return {of_jobs, threads};
}

std::unique_ptr<Engine> MakeEngine(const std::filesystem::path& root, const EngineOptions& options,
                                   const RunResources& resources,
                                   const ProcessBytes& process_bytes) {
  if (options.kind == EngineKind::kLocal) return MakeLocalEngine();
  return MakeJobEngine(root, options, resources.context.driver, resources.threads, process_bytes);
}

std::map<std::string, StageDivision> DivideStages(const Engine& engine,
                                                  const std::vector<Task>& tasks,
                                                  const RunPlan& plan) {
  std::map<std::string, StageDivision> divisions;
  for (const PlannedStage& stage : plan.stages) {
    if (stage.num_run == 0) continue;
    const StageDivision division = engine.Divide(tasks, plan, stage);
    if (division.num_jobs > 0) divisions[stage.name] = division;
  }
  return divisions;
}

bool AskToKeepJobs(size_t num_jobs, Console* console) {
  if (num_jobs == 0) return false;
  const std::optional<std::string> answer = console->Ask(
      fmt::format("{} jobs of this run wait or run. Cancel them? [Y/n] (n: they go on, and the "
                  "next start picks them up) ",
                  num_jobs));
  return answer && !answer->empty() && (answer->front() == 'n' || answer->front() == 'N');
}

}  // namespace lsmvs
