#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "lsmvs/execution/task.h"

namespace lsmvs {

// Divides tasks that can run at the same time into jobs. Each slice holds tasks of about `seconds`
// of CPU time in all, at least one, that read the same files where that can be: beginning with the
// first task that is left, the one that shares most inputs with the slice follows. Inputs that more
// than 64 tasks read say nothing. `task_idxs` are positions in `tasks`; so are those returned, in
// the order in which they are to run. O(number of inputs).
std::vector<std::vector<size_t>> SliceTasks(const std::vector<Task>& tasks,
                                            std::span<const size_t> task_idxs, double seconds);

// The tasks of the stage that are in `task_idxs`, in rounds: a task's inputs are made by tasks of
// earlier rounds or by none of these.
std::vector<std::vector<size_t>> RoundsOf(const std::vector<Task>& tasks,
                                          std::span<const size_t> task_idxs);

}  // namespace lsmvs
