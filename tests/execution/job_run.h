#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lsmvs/execution/engine.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "text_tasks.h"

namespace lsmvs {

// Keeps what it is told, and lets jobs go on or not.
class NotingObserver : public SilentObserver {
 public:
  void OnNote(const std::string& note) override { notes.push_back(note); }
  bool KeepJobs(size_t num_jobs) override {
    num_jobs_at_end = num_jobs;
    return keep_jobs;
  }
  // All notes, a line each.
  std::string Notes() const;

  bool keep_jobs = false;
  size_t num_jobs_at_end = 0;
  std::vector<std::string> notes;
};

// A folder with the run of MakeJobTasks().
class JobRun {
 public:
  JobRun();
  const std::filesystem::path& root() const { return folder_.path(); }

  // Runs what is to be done. Throws what RunTasks throws.
  void Run(const EngineOptions& options, const std::string& word = "word",
           const std::atomic<bool>* cancel = nullptr);
  // The same in a process of its own, which is killed once `seconds` have gone by after the file
  // has appeared, or at once if it has ended.
  void RunAndKill(const EngineOptions& options, const std::filesystem::path& file, double seconds);
  // Results by their names: not what serves the run.
  std::map<std::string, std::string> Results() const;

  NotingObserver observer;

 private:
  TemporaryFolder folder_;
};

// What a local run gives.
const std::map<std::string, std::string>& LocalResults();

// Jobs of one task each, by the command.
EngineOptions CommandEngine(const std::string& command);

}  // namespace lsmvs
