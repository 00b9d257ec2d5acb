#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/execution/engine.h"
#include "lsmvs/execution/run_plan.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/execution/task.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"

namespace lsmvs {

// What a plan is printed with.
struct PlanHeader {
  std::string workspace;  // folder
  int num_views = 0;
  double num_pixels = 0;  // that are worked on, over all views
  size_t num_points = 0;  // of the sparse model
  int num_threads = 1;
  size_t process_bytes = 0;         // that the process takes before the first stage
  size_t memory_allowed_bytes = 0;  // for the process as a whole
  bool has_compact_maps = false;    // that it writes
  // Stages that are done by jobs, by name.
  std::map<std::string, StageDivision> divisions = {};
  std::vector<std::string> notes;  // lines below the head: what the user should know beforehand
};

// Wall time of a stage, and of all, on machines that have nothing else to do.
double PlannedSecondsOf(const PlanHeader& header, const PlannedStage& stage);
double PlannedSecondsOf(const PlanHeader& header, const RunPlan& plan);

// The table that is printed before a run: what each stage has to do and why, its time on an idle
// machine, the memory of the process at its highest, and what it writes to the disk.
std::string PlanText(const PlanHeader& header, const RunPlan& plan);

// One line for each way in which photos have no or few neighbours for stereo, with why and which;
// nothing where all have enough.
std::vector<std::string> NeighborNotes(const Scene& scene,
                                       const std::vector<std::vector<Neighbor>>& neighbors);

// Throws MemoryError, with advice, if the process needs more in a stage that runs than is allowed.
// `image_size` is the longest side worked on.
void CheckPlanFits(const PlanHeader& header, const RunPlan& plan, int image_size);

// Throws Error(kFileSystem), with advice, if the files of the run, at their most, do not fit into
// what is free where it writes.
void CheckPlanFitsDisk(const PlanHeader& header, const RunPlan& plan, uint64_t free_bytes,
                       int image_size);

// A file system, as the kernel tells them apart, and what is free on it.
struct Disk {
  uint64_t device = 0;
  uint64_t free_bytes = 0;
};

// Throws Error(kFileSystem), with advice, if the largest scratch file does not fit where it goes,
// beside the results if these go to the same disk. `results`: where, if that is known.
void CheckScratchFits(const PlanHeader& header, const RunPlan& plan,
                      const std::optional<Disk>& results);

// The disk of a folder, or of the nearest one above it that is there; nothing if that cannot be
// known.
std::optional<Disk> DiskOf(std::filesystem::path folder);
// Where the tasks that run write.
std::optional<Disk> FindDisk(const std::vector<Task>& tasks, const RunPlan& plan);

// The results with their sizes, and whether this run made them. `plan` is that of the tasks.
std::string ResultText(const std::vector<Task>& tasks, const RunPlan& plan);

// "1,234,567 points, 12 maps": figures of a stage worth showing.
std::string CountsText(const TaskCounts& counts);

}  // namespace lsmvs
