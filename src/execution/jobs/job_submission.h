#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/execution/jobs/ready_tasks.h"
#include "lsmvs/execution/jobs/stage_jobs.h"

namespace lsmvs {

// Makes jobs of a stage's tasks and submits them.
class JobSubmission {
 public:
  JobSubmission(StageJobs* jobs, ReadyTasks* tasks);

  // Takes over the jobs of an earlier driver that do what is to be done; cancels the others, and
  // removes their folders.
  void Adopt();
  // Submits what is to be submitted again, and of the tasks that are ready as many as machines have
  // use for.
  void Submit();
  // Whether tasks wait to be submitted again, and can be now.
  bool MaySubmitAgain() const;

 private:
  std::optional<LiveBatch> Reopen(const std::filesystem::path& folder,
                                  const std::map<std::string, size_t>& task_of_name);
  bool IsSame(const OrderedTask& ordered, size_t task_idx);
  void SubmitAgain();
  void SubmitReady();
  size_t NumWanted() const;
  size_t NumFree() const;
  bool IsShort(const std::vector<size_t>& slice) const;
  void SubmitBatch(const std::vector<std::vector<size_t>>& slices, const TaskHistory& history);
  void AddSlice(const std::vector<size_t>& task_idxs, const TaskHistory& history, LiveBatch* batch);

  StageJobs& jobs_;
  ReadyTasks& tasks_;
  const SliceLengths lengths_;
};

}  // namespace lsmvs
