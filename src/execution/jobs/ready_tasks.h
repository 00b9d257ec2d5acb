#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

#include "lsmvs/execution/task.h"

namespace lsmvs {

// Which of a stage's tasks that are to run can be started: those whose inputs are made by none of
// the others, or by tasks that are done.
class ReadyTasks {
 public:
  // `task_idxs`: positions in `tasks` of those that are to run.
  ReadyTasks(const std::vector<Task>& tasks, std::span<const size_t> task_idxs);

  const std::set<size_t>& ready() const { return ready_; }
  // Tasks that wait for others.
  size_t NumBlocked() const { return blockers_.size(); }
  // CPU time of tasks that are ready or wait for others [s].
  double seconds_left() const { return seconds_left_; }
  // The task is in a job.
  void Take(size_t task_idx);
  // Those that wait for nothing else are ready now.
  void OnDone(size_t task_idx);

 private:
  const std::vector<Task>& tasks_;
  std::set<size_t> ready_;
  std::unordered_map<size_t, size_t> blockers_;              // of a task: how many it waits for
  std::unordered_map<size_t, std::vector<size_t>> waiting_;  // for a task
  double seconds_left_ = 0;
};

}  // namespace lsmvs
