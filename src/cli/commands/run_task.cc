#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "lsmvs/cli/command_table.h"
#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/colmap_adapter/option_synonyms.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/program/run_program.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

std::unique_ptr<Command> FindCommand(const std::string& name) {
  std::unique_ptr<Command> mesher = MakeMesherCommand();
  if (mesher->Info().name == name) return mesher;
  for (const CommandFactory& make : CommandTable()) {
    std::unique_ptr<Command> command = make();
    if (command->Info().name == name) return command;
  }
  throw UsageError(
      fmt::format("the job repeats the command '{}', which this version of the program "
                  "does not know; install the same version on all machines",
                  name));
}

class RunTaskCommand : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info{
        "run_task",
        "A job of a run on many machines",
        "Part of runs with --engine slurm or command, which start it on their "
        "machines: runs the tasks of one job and leaves their results for the run that "
        "waits for them.",
        {"lsmvs run_task project/dense/0 --task 12.3"},
        {"workspace_path", "task"},
        "workspace_path"};
    info.is_internal = true;
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("workspace_path", &workspace_path_, "Folder of the run.");
    options->Add("task", &task_, "Number of the batch, and of the job in it.");
  }

  void Run(const CommandContext& /*context*/) override {
    const CommandJob job{std::filesystem::absolute(workspace_path_), ParseJobNumber(task_)};
    const JobOrder order = ReadJobOrder(JobsFolder(job.root) / job.number.batch);
    std::error_code error;
    std::filesystem::current_path(order.working_folder, error);
    if (error) {
      throw InputError(order.working_folder.string(), "cannot be entered: " + error.message(),
                       "start the run in a folder that all machines see");
    }
    std::vector<std::string> arguments = order.arguments;
    arguments.push_back(fmt::format("--num_threads={}", order.num_threads));
    arguments.push_back(
        fmt::format("--max_memory={}MB", ProgramMemoryBytes(order.memory_bytes) / 1'000'000));
    const std::unique_ptr<Command> command = FindCommand(order.command_name);
    RunCommandForJob(command.get(), arguments, job, ColmapSynonyms());
  }

 private:
  std::string workspace_path_, task_;
};

}  // namespace

std::unique_ptr<Command> MakeRunTaskCommand() { return std::make_unique<RunTaskCommand>(); }

}  // namespace lsmvs
