#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lsmvs/execution/run_plan.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/execution/task.h"

namespace lsmvs {

// What a plan is printed with.
struct PlanHeader {
  std::string workspace;  // folder
  int num_views = 0;
  double num_pixels = 0;  // that are worked on, over all views
  size_t num_points = 0;  // of the sparse model
  int num_threads = 1;
  size_t memory_budget_bytes = 0;
};

// The table that is printed before a run: what each stage has to do and why, time, memory.
std::string PlanText(const PlanHeader& header, const RunPlan& plan);

// Throws MemoryError, with advice, if a stage that runs needs more than the budget. `image_size` is
// the longest side worked on.
void CheckPlanFits(const PlanHeader& header, const RunPlan& plan, int image_size);

// The results with their sizes, and whether this run made them. `plan` is that of the tasks.
std::string ResultText(const std::vector<Task>& tasks, const RunPlan& plan);

// "1,234,567 points, 12 maps": figures of a stage worth showing.
std::string CountsText(const TaskCounts& counts);

}  // namespace lsmvs
