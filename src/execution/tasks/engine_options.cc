#include <sstream>

#include "lsmvs/execution/engine.h"

namespace lsmvs {

void EngineOptions::Describe(OptionSet* options) {
  options->AddEnum("engine", &kind,
                   "Where the work is done: local, by this process; slurm, by jobs of Slurm; "
                   "command, by jobs that --submit_command runs. The result has the same bytes.",
                   {{"local", EngineKind::kLocal},
                    {"slurm", EngineKind::kSlurm},
                    {"command", EngineKind::kCommand}});
  options->Add("submit_command", &submit_command,
               "With --engine command: a line for sh that runs jobs and returns when all have "
               "ended. {commands} stands for a file with one command a line, {script} for a "
               "program that takes the number of a line (from 1), or finds it in the variables of "
               "PBS, SGE or Slurm; {count}, {threads}, {memory_mb} and {seconds} for the number of "
               "jobs and what each needs; {folder} for a folder that may be used.");
  options->Add("jobs_at_once", &jobs_at_once,
               "With --engine command: how many jobs the command runs at once, about; work is "
               "divided accordingly.",
               {1, 100000});
  options->Add("job_minutes", &job_minutes,
               "Short tasks share a job of at most this length [minutes]; 0: each has its own.",
               {0, 10000});
  options->Add("max_attempts", &max_attempts,
               "How often a task is started whose job or node fails, before the run gives up.",
               {1, 100});
  options->Add("Slurm.partition", &partition, "Partition of the jobs.");
  options->Add("Slurm.account", &account, "Account that the jobs are charged to.");
  options->Add("Slurm.time", &time,
               "Time limit of each job, as Slurm writes it (2:00:00); without it four times what "
               "the plan says, and ten minutes.");
  options->Add("Slurm.max_jobs", &max_jobs, "Jobs of this run that run at once, at most.",
               {1, 100000});
  options->Add("Slurm.extra", &extra, "Further options of sbatch, with blanks between.");
  options->MarkRare({"submit_command", "jobs_at_once", "job_minutes", "max_attempts"});
}

bool EngineOptions::Check(std::string* error) const {
  if (!CheckOptions(*this, error)) return false;
  if (kind == EngineKind::kCommand && submit_command.empty()) {
    *error =
        "engine is command, but submit_command is empty: it says how jobs are run, such as "
        "'parallel -a {commands}'";
    return false;
  }
  if (kind == EngineKind::kCommand && submit_command.find("{commands}") == std::string::npos &&
      submit_command.find("{script}") == std::string::npos) {
    *error = "submit_command is '" + submit_command +
             "', but must hold {commands} or {script}, which stand for the jobs";
    return false;
  }
  return true;
}

}  // namespace lsmvs
