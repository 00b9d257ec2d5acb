#include "lsmvs/cli/plan_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lsmvs/cli/common_options.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// What there is to do in a stage.
std::string WorkText(const PlannedStage& stage) {
  const size_t num_tasks = stage.end - stage.begin;
  if (stage.num_run == num_tasks) {
    return num_tasks == 1 ? stage.reason : fmt::format("{} steps, {}", num_tasks, stage.reason);
  }
  if (stage.num_run > 0) {
    return fmt::format("{} of {} steps, {}", stage.num_run, num_tasks, stage.reason);
  }
  if (stage.num_foreign > 0) return "not made by us: used as it is";
  return stage.num_up_to_date > 0 ? "up to date" : "not needed";
}

std::string StageLine(const PlannedStage& stage, int num_threads) {
  if (stage.num_run == 0) return fmt::format("  {:<20} {}\n", stage.name, WorkText(stage));
  return fmt::format("  {:<20} {:<40} {:>10} {:>8}\n", stage.name, WorkText(stage),
                     FormatSeconds(stage.cost.cpu_seconds / num_threads),
                     FormatBytes(stage.cost.peak_bytes));
}

const PlannedStage* HungriestStage(const RunPlan& plan) {
  const PlannedStage* hungriest = nullptr;
  for (const PlannedStage& stage : plan.stages) {
    if (stage.num_run == 0) continue;
    if (hungriest == nullptr || stage.cost.peak_bytes > hungriest->cost.peak_bytes) {
      hungriest = &stage;
    }
  }
  return hungriest;
}

// Memory goes with the number of pixels; rounded down to hundreds.
int SizeThatFits(int image_size, double needed, double budget) {
  const double side = image_size * std::sqrt(budget / needed);
  return static_cast<int>(side / 100) * 100;
}

std::string Commas(double number) {
  std::string digits = fmt::format("{:.0f}", number);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<size_t>(at), ",");
  }
  return digits;
}

std::string StateText(TaskState state) {
  switch (state) {
    case TaskState::kRun:
      return "written";
    case TaskState::kUpToDate:
      return "up to date";
    case TaskState::kForeign:
      return "used as it was";
    case TaskState::kNotNeeded:
      break;
  }
  return "";
}

}  // namespace

std::string PlanText(const PlanHeader& header, const RunPlan& plan) {
  std::string text =
      fmt::format("{}\n  {} views, {:.1f} megapixels, {} sparse points; {} threads, {} of memory\n",
                  header.workspace, header.num_views, header.num_pixels / 1e6,
                  Commas(static_cast<double>(header.num_points)), header.num_threads,
                  FormatBytes(header.memory_budget_bytes));
  if (plan.NumToRun() == 0) return text + "  everything is up to date\n";
  text += fmt::format("  {:<20} {:<40} {:>10} {:>8}\n", "stage", "to do", "time", "memory");
  for (const PlannedStage& stage : plan.stages) text += StageLine(stage, header.num_threads);
  const CostEstimate cost = plan.Cost();
  return text + fmt::format("  {:<20} {:<40} {:>10} {:>8}\n", "all (estimated)", "",
                            FormatSeconds(cost.cpu_seconds / header.num_threads),
                            FormatBytes(cost.peak_bytes));
}

void CheckPlanFits(const PlanHeader& header, const RunPlan& plan, int image_size) {
  const PlannedStage* stage = HungriestStage(plan);
  if (stage == nullptr || stage->cost.peak_bytes <= header.memory_budget_bytes) return;
  const int size = SizeThatFits(image_size, static_cast<double>(stage->cost.peak_bytes),
                                static_cast<double>(header.memory_budget_bytes));
  const std::string advice =
      size >= 200 ? fmt::format("give --max_image_size {} or less, or a lower --quality", size)
                  : std::string("use fewer photos");
  throw MemoryError(fmt::format(
      "{}: {} needs about {} of memory, but {} may be used; {}, or allow more with --max_memory",
      header.workspace, stage->name, FormatBytes(stage->cost.peak_bytes),
      FormatBytes(header.memory_budget_bytes), advice));
}

std::string ResultText(const std::vector<Task>& tasks, const RunPlan& plan) {
  std::string text;
  std::map<std::string, size_t> files_of_stage;
  for (const Task& task : tasks) files_of_stage[task.stage] += task.wanted ? 1 : 0;
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (!tasks[i].wanted || files_of_stage[tasks[i].stage] > 1) continue;
    const fs::path& path = tasks[i].outputs.front();
    text += fmt::format("  {}  ({}, {})\n", path.string(), FormatBytes(fs::file_size(path)),
                        StateText(plan.tasks[i].state));
  }
  for (const PlannedStage& stage : plan.stages) {
    if (files_of_stage[stage.name] <= 1) continue;
    text += fmt::format("  {}  ({} maps)\n",
                        tasks[stage.end - 1].outputs.front().parent_path().string(),
                        files_of_stage[stage.name]);
  }
  return text;
}

std::string CountsText(const TaskCounts& counts) {
  std::string text;
  for (const char* name : {"points", "vertices", "faces"}) {
    const auto found = counts.find(name);
    if (found == counts.end()) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", Commas(found->second), name);
  }
  return text;
}

}  // namespace lsmvs
