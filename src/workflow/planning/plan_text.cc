#include "lsmvs/workflow/planning/plan_text.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lsmvs/pipeline/reconstruction_options.h"
#include "lsmvs/util/duration_text.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"

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

std::string Row(const std::string& stage, const std::string& work, const std::string& time,
                const std::string& memory, const std::string& disk) {
  return fmt::format("  {:<20} {:<40} {:>10} {:>8} {:>8}\n", stage, work, time, memory, disk);
}

// How a stage works that does not fit into memory.
std::string ScratchLine(const PlannedStage& stage) {
  if (stage.scratch_bytes == 0) return "";
  const uint64_t num_parts = (stage.scratch_bytes + stage.cost.peak_bytes - 1) /
                             std::max<size_t>(1, stage.cost.peak_bytes);
  const std::string parts = num_parts > 1 ? fmt::format("in {} parts, ", num_parts) : "";
  return fmt::format("  {:<20} {}with a scratch file of {}\n", "", parts,
                     FormatBytes(stage.scratch_bytes));
}

// Why a stage is not divided.
std::string WhyAlone(const std::string& stage) {
  if (stage == kFusionStage) return "its photos are few";
  if (stage == kSurfaceStage) return "tetrahedra and the cut need all points";
  if (stage == kRefinementStage) return "each step needs the one before";
  if (stage == kTexturingStage) return "the choice of photos needs all faces";
  return "it has one step";
}

// How a stage is divided into jobs.
std::string JobLine(const PlannedStage& stage, const PlanHeader& header) {
  const auto found = header.divisions.find(stage.name);
  if (found == header.divisions.end()) return "";
  const StageDivision& division = found->second;
  const std::string needs = fmt::format("{} {} and {}", division.num_threads,
                                        division.num_threads == 1 ? "thread" : "threads",
                                        FormatBytes(division.memory_bytes));
  if (division.num_helpers > 0) {
    return fmt::format("  {:<20} a single job, with {} {}: {} each\n", "", division.num_helpers,
                       division.num_helpers == 1 ? "helper" : "helpers", needs);
  }
  if (division.num_jobs == 1) {
    return fmt::format("  {:<20} a single job, not divided ({}): {}\n", "",
                       stage.end - stage.begin == 1 ? WhyAlone(stage.name)
                       : stage.num_run == 1         ? "one task is left"
                                                    : "it is short",
                       needs);
  }
  return fmt::format("  {:<20} {} jobs of about {}, {} at once: {} each\n", "", division.num_jobs,
                     FormatSeconds(division.job_seconds), division.jobs_at_once, needs);
}

std::string StageLine(const PlannedStage& stage, const PlanHeader& header) {
  if (stage.num_run == 0) return fmt::format("  {:<20} {}\n", stage.name, WorkText(stage));
  return Row(stage.name, WorkText(stage), FormatSeconds(PlannedSecondsOf(header, stage)),
             FormatBytes(header.process_bytes + stage.cost.peak_bytes),
             FormatBytes(stage.output_bytes)) +
         JobLine(stage, header) + ScratchLine(stage);
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

// Memory and disk go with the number of pixels; rounded down to hundreds.
int SizeThatFits(int image_size, double needed, double budget) {
  const double side = image_size * std::sqrt(std::max(0.0, budget) / needed);
  return static_cast<int>(side / 100) * 100;
}

std::string FirstNames(const std::vector<std::string>& names) {
  constexpr size_t kMaxNames = 5;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMaxNames); ++i) {
    text += (i > 0 ? ", " : "") + names[i];
  }
  return names.size() > kMaxNames ? text + ", ..." : text;
}

std::string SizeAdvice(int size) {
  return size >= 200 ? fmt::format("give --max_image_size {} or less, or a lower --quality", size)
                     : std::string("use fewer photos");
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

double PlannedSecondsOf(const PlanHeader& header, const PlannedStage& stage) {
  const auto found = header.divisions.find(stage.name);
  if (found == header.divisions.end()) return stage.cost.cpu_seconds / header.num_threads;
  const StageDivision& division = found->second;
  return stage.cost.cpu_seconds / division.num_threads / static_cast<double>(division.jobs_at_once);
}

double PlannedSecondsOf(const PlanHeader& header, const RunPlan& plan) {
  double seconds = 0;
  for (const PlannedStage& stage : plan.stages) seconds += PlannedSecondsOf(header, stage);
  return seconds;
}

std::string PlanText(const PlanHeader& header, const RunPlan& plan) {
  std::string text =
      fmt::format("{}\n  {} views, {:.1f} megapixels, {} sparse points; {} threads, {} of memory\n",
                  header.workspace, header.num_views, header.num_pixels / 1e6,
                  Commas(static_cast<double>(header.num_points)), header.num_threads,
                  FormatBytes(header.memory_allowed_bytes));
  for (const std::string& note : header.notes) text += "  " + note + "\n";
  if (plan.NumToRun() == 0) return text + "  everything is up to date\n";
  text += Row("stage", "to do", "time", "memory", "disk");
  for (const PlannedStage& stage : plan.stages) text += StageLine(stage, header);
  if (plan.peak_scratch_bytes > 0) {
    text += fmt::format("  scratch files go to {}\n", plan.scratch_folder.string());
  }
  const CostEstimate cost = plan.Cost();
  return text + Row("all (estimated)", "with the machine to itself",
                    FormatSeconds(PlannedSecondsOf(header, plan)),
                    FormatBytes(header.process_bytes + cost.peak_bytes),
                    FormatBytes(plan.peak_disk_bytes));
}

std::vector<std::string> NeighborNotes(const Scene& scene,
                                       const std::vector<std::vector<Neighbor>>& neighbors) {
  std::vector<std::string> alone, single, overlapping;
  for (size_t v = 0; v < neighbors.size(); ++v) {
    const std::string& name = scene.views[v].name;
    if (neighbors[v].empty()) {
      alone.push_back(name);
    } else if (neighbors[v].front().by_overlap) {
      overlapping.push_back(name);
    } else if (neighbors[v].size() == 1) {
      single.push_back(name);
    }
  }
  std::vector<std::string> notes;
  const auto add = [&](const std::vector<std::string>& names, const char* one, const char* many) {
    if (names.empty()) return;
    notes.push_back(names.size() == 1
                        ? fmt::format("1 photo {}: {}", one, names.front())
                        : fmt::format("{} photos {}: {}", names.size(), many, FirstNames(names)));
  };
  add(alone, "without a neighbour (no other shows the same place at a useful angle) gets no depth",
      "without a neighbour (no other shows the same place at a useful angle) get no depth");
  add(single, "with a single neighbour gets few depths that others confirm",
      "with a single neighbour get few depths that others confirm");
  add(overlapping, "that shares too few sparse points takes its neighbours by overlap",
      "that share too few sparse points take their neighbours by overlap");
  return notes;
}

void CheckPlanFits(const PlanHeader& header, const RunPlan& plan, int image_size) {
  const PlannedStage* stage = HungriestStage(plan);
  if (stage == nullptr) return;
  const size_t needed = header.process_bytes + stage->cost.peak_bytes;
  if (needed <= header.memory_allowed_bytes) return;
  const double left =
      static_cast<double>(header.memory_allowed_bytes) - static_cast<double>(header.process_bytes);
  // The surface of a cloud that is there does not depend on the size of the photos.
  const bool is_surface_alone = plan.stages.size() == 1 && stage->name == kSurfaceStage;
  const std::string advice =
      is_surface_alone
          ? std::string("give a --bounding_box or a larger --VisibilityMeshing.max_proj_dist")
          : SizeAdvice(SizeThatFits(image_size, static_cast<double>(stage->cost.peak_bytes), left));
  throw MemoryError(fmt::format(
      "{}: {} needs about {} of memory, but {} may be used; {}, or allow more with --max_memory",
      header.workspace, stage->name, FormatBytes(needed), FormatBytes(header.memory_allowed_bytes),
      advice));
}

void CheckPlanFitsDisk(const PlanHeader& header, const RunPlan& plan, uint64_t free_bytes,
                       int image_size) {
  if (plan.peak_disk_bytes <= free_bytes) return;
  const int size = SizeThatFits(image_size, static_cast<double>(plan.peak_disk_bytes),
                                static_cast<double>(free_bytes));
  const bool has_maps = std::any_of(plan.stages.begin(), plan.stages.end(), [](const auto& stage) {
    return stage.num_run > 0 && stage.name == kStereoStage;
  });
  throw Error(
      ExitCode::kFileSystem,
      fmt::format("{}: the results need about {} of disk, but {} are free; make room, {}{}, "
                  "or give --ignore_disk_space 1 to start nevertheless",
                  header.workspace, FormatBytes(plan.peak_disk_bytes), FormatBytes(free_bytes),
                  has_maps && !header.has_compact_maps
                      ? "give --map_format compact, with which depth maps take an eighth, "
                      : "",
                  SizeAdvice(size)));
}

void CheckScratchFits(const PlanHeader& header, const RunPlan& plan,
                      const std::optional<Disk>& results) {
  if (plan.peak_scratch_bytes == 0) return;
  const std::optional<Disk> scratch = DiskOf(plan.scratch_folder);
  if (!scratch) return;
  const bool same_disk = results && results->device == scratch->device;
  const uint64_t needed = plan.peak_scratch_bytes + (same_disk ? plan.peak_disk_bytes : 0);
  if (needed <= scratch->free_bytes) return;
  throw Error(
      ExitCode::kFileSystem,
      fmt::format(
          "{}: {} about {} of disk, but {} are free in {}; make room, name another folder by "
          "--scratch_path, allow more memory with --max_memory, or give --ignore_disk_space 1 to "
          "start nevertheless",
          header.workspace, same_disk ? "scratch file and results need" : "the scratch file needs",
          FormatBytes(needed), FormatBytes(scratch->free_bytes), plan.scratch_folder.string()));
}

std::optional<Disk> DiskOf(fs::path folder) {
  folder = fs::absolute(folder);
  while (!fs::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  struct stat status = {};
  if (error || ::stat(folder.c_str(), &status) != 0) return std::nullopt;
  return Disk{status.st_dev, space.available};
}

std::optional<Disk> FindDisk(const std::vector<Task>& tasks, const RunPlan& plan) {
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (plan.tasks[i].state != TaskState::kRun) continue;
    return DiskOf(fs::absolute(tasks[i].outputs.front()).parent_path());
  }
  return std::nullopt;
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
