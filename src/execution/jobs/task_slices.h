#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "lsmvs/execution/task.h"

namespace lsmvs {

// Lengths of jobs [CPU s]. What is left when a job is cut off is divided by twice the number of
// jobs that run at once: the first jobs are long, so that few have to be started, and the last ones
// short, so that machines finish at the same time.
struct SliceLengths {
  double longest = 0;
  double shortest = 0;
  size_t jobs_at_once = 1;

  double Next(double seconds_left) const;
};

// Divides tasks that can run at the same time into jobs. Each slice holds tasks of the next length
// at most, at least one, that read the same files where that can be: beginning with the first task
// that is left, the one that shares most inputs with the slice follows. Inputs that more than 64
// tasks read say nothing. `seconds_left`: CPU time of these tasks, and of others that run with
// them. `task_idxs` are positions in `tasks`; so are those returned, in the order in which they are
// to run. Ends after `max_slices`. O(number of inputs).
std::vector<std::vector<size_t>> SliceTasks(const std::vector<Task>& tasks,
                                            std::span<const size_t> task_idxs,
                                            const SliceLengths& lengths, double seconds_left,
                                            size_t max_slices = std::numeric_limits<size_t>::max());

// The tasks of the stage that are in `task_idxs`, in rounds: a task's inputs are made by tasks of
// earlier rounds or by none of these.
std::vector<std::vector<size_t>> RoundsOf(const std::vector<Task>& tasks,
                                          std::span<const size_t> task_idxs);

}  // namespace lsmvs
