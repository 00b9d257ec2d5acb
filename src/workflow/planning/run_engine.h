#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/run_plan.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/workflow/stage_options.h"

namespace lsmvs {

// Threads and memory that the tasks of a run have: those of this process, or of jobs. Jobs take
// what the user says; else with Slurm up to 4 threads, up to 16 where a stage is a single job, and
// the memory of the largest node; with a command one thread, all cores where a stage is a single
// job, and the memory of this machine. The context is for the larger number of threads.
struct RunResources {
  CommandContext context;
  JobThreads threads;
};
RunResources FindResources(const EngineOptions& options, const CommandContext& context);

// The engine that the options name. Throws UsageError for options that do not fit together.
std::unique_ptr<Engine> MakeEngine(const std::filesystem::path& root, const EngineOptions& options,
                                   const RunResources& resources,
                                   const ProcessBytes& process_bytes);

// How the stages that run are divided, by their names; those that run in this process are left out.
std::map<std::string, StageDivision> DivideStages(const Engine& engine,
                                                  const std::vector<Task>& tasks,
                                                  const RunPlan& plan);

// Asks the user, who has stopped the run, whether its jobs are to go on. Where nobody can be asked
// they are not.
bool AskToKeepJobs(size_t num_jobs, Console* console);

}  // namespace lsmvs
