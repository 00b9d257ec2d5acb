#include "lsmvs/execution/jobs/ready_tasks.h"

#include <string>

namespace lsmvs {

ReadyTasks::ReadyTasks(const std::vector<Task>& tasks, std::span<const size_t> task_idxs)
    : tasks_(tasks) {
  std::unordered_map<std::string, size_t> maker;
  for (const size_t i : task_idxs) {
    for (const auto& output : tasks[i].outputs) maker[output.string()] = i;
  }
  for (const size_t i : task_idxs) {
    std::set<size_t> makers;
    for (const auto& input : tasks[i].inputs) {
      const auto made = maker.find(input.string());
      if (made != maker.end() && made->second != i) makers.insert(made->second);
    }
    for (const size_t made_by : makers) waiting_[made_by].push_back(i);
    if (makers.empty()) {
      ready_.insert(i);
    } else {
      blockers_[i] = makers.size();
    }
    seconds_left_ += tasks[i].cost.cpu_seconds;
  }
}

void ReadyTasks::Take(size_t task_idx) {
  if (ready_.erase(task_idx) > 0) seconds_left_ -= tasks_[task_idx].cost.cpu_seconds;
}

void ReadyTasks::OnDone(size_t task_idx) {
  Take(task_idx);
  const auto found = waiting_.find(task_idx);
  if (found == waiting_.end()) return;
  for (const size_t i : found->second) {
    if (--blockers_.at(i) > 0) continue;
    blockers_.erase(i);
    ready_.insert(i);
  }
  waiting_.erase(found);
}

}  // namespace lsmvs
