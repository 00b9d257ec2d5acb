#include "lsmvs/workflow/planning/run_reconstruction.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <set>

#include "lsmvs/colmap_adapter/cloud_inputs.h"
#include "lsmvs/colmap_adapter/joined_models.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/workspace_files.h"
#include "lsmvs/execution/run_store.h"
#include "lsmvs/execution/run_tasks.h"
#include "lsmvs/pipeline/job_scene.h"
#include "lsmvs/program/version.h"
#include "lsmvs/scene/contrast_check.h"
#include "lsmvs/util/duration_text.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/workflow/planning/plan_text.h"
#include "lsmvs/workflow/planning/run_engine.h"

namespace lsmvs {

namespace {

// Shows the stages of a run.
class ConsoleObserver : public RunObserver {
 public:
  ConsoleObserver(const RunPlan& plan, const PlanHeader& header, Console* console)
      : header_(header), seconds_to_come_(PlannedSecondsOf(header, plan)), console_(console) {}

  void OnStageBegin(const PlannedStage& stage, double fraction_done) override {
    const double seconds = PlannedSecondsOf(header_, stage);
    seconds_to_come_ -= seconds;
    console_->Begin(stage.name, fraction_done, {seconds, seconds_to_come_});
  }
  void OnStageEnd(const StageSummary& summary) override {
    std::string note = CountsText(summary.counts);
    if (!note.empty()) note += ", ";
    note += fmt::format("{} of memory", FormatBytes(summary.peak_bytes));
    console_->End(note);
  }
  void OnNote(const std::string& note) override { console_->Note(note); }
  bool KeepJobs(size_t num_jobs) override { return AskToKeepJobs(num_jobs, console_); }

 private:
  const PlanHeader& header_;
  double seconds_to_come_;  // of the stages that have not begun, by the plan
  Console* console_;
};

// Pages of the program and its libraries that only the stages touch.
constexpr size_t kCodeBytes = size_t{12} << 20;

// What this process takes beside the stages, and jobs that have all of the scene or, for depth
// maps, what JobScene holds.
ProcessBytes FindProcessBytes(const Reconstruction& reconstruction, const CommandContext& context) {
  constexpr size_t kBytesOfView = 8192;  // with its tasks: measured on 10,000 photos
  const size_t views = kBytesOfView * reconstruction.scene.views.size();
  ProcessBytes bytes;
  bytes.alone = ResidentBytes() + kCodeBytes;
  bytes.shared = std::min(bytes.alone, context.process_bytes + kCodeBytes + views);
  return bytes;
}

// Whether photos are compared.
bool Matches(const RunPlan& plan) {
  return std::any_of(plan.stages.begin(), plan.stages.end(), [](const PlannedStage& stage) {
    return stage.num_run > 0 && (stage.name == kStereoStage || stage.name == kQuasiDenseStage);
  });
}

PlanHeader MakeHeader(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                      const RunPlan& plan, size_t process_bytes, const CommandContext& context) {
  PlanHeader header;
  header.workspace = workspace.folder.string();
  header.num_views = reconstruction.scene.num_views();
  header.num_pixels = NumPixels(reconstruction);
  header.num_points = reconstruction.scene.points.size();
  header.num_threads = context.run.num_threads();
  header.has_compact_maps = reconstruction.options.map_precision == MapPrecision::kCompact;
  header.process_bytes = process_bytes;
  header.memory_allowed_bytes = context.AllowedBytes();
  if (Matches(plan)) header.notes = NeighborNotes(reconstruction.scene, reconstruction.neighbors);
  return header;
}

int LongestSide(const Reconstruction& reconstruction) {
  int longest = 1;
  for (int i = 0; i < reconstruction.scene.num_views(); ++i) {
    const PinholeCamera camera = reconstruction.images->Camera(i, 0);
    longest = std::max({longest, camera.width, camera.height});
  }
  return longest;
}

// Masks of other names than expected would go unnoticed.
void WarnWithoutMasks(const Reconstruction& reconstruction) {
  const Scene& scene = reconstruction.scene;
  if (scene.mask_folder.empty()) return;
  for (int i = 0; i < scene.num_views(); ++i) {
    if (!reconstruction.images->source(i).mask_path.empty()) return;
  }
  LOG(WARNING) << scene.mask_folder << ": holds no mask of these photos; that of "
               << scene.views.front().name << " is to be named " << scene.views.front().name
               << ".png";
}

// What the user should know of the photos before the plan.
std::string PhotoNotes(const Reconstruction& reconstruction) {
  const int num_views = reconstruction.scene.num_views();
  int num_alpha = 0;
  for (int i = 0; i < num_views; ++i) num_alpha += reconstruction.images->source(i).alpha_is_mask;
  if (num_alpha == 0) return "";
  return fmt::format(
      "{} of {} photos have an alpha channel: transparent pixels are not used (--alpha_mask 0 uses "
      "them)\n",
      num_alpha, num_views);
}

PlanOptions MakePlanOptions(const DenseWorkspace& workspace, const StageOptions& stage,
                            size_t process_bytes, const CommandContext& context) {
  const std::filesystem::path scratch(stage.scratch_path);
  if (!scratch.empty() && !std::filesystem::is_directory(scratch)) {
    throw InputError(stage.scratch_path, "is no folder", "make it, or correct --scratch_path");
  }
  PlanOptions options;
  options.overwrite = stage.overwrite;
  options.memory_bytes = context.AllowedBytes() - std::min(context.AllowedBytes(), process_bytes);
  options.process_bytes = process_bytes;
  options.num_parts = stage.num_parts;
  options.scratch_folder = scratch.empty() ? workspace.folder / "lsmvs" : scratch;
  return options;
}

bool RunsStereo(const RunPlan& plan) {
  return std::any_of(plan.stages.begin(), plan.stages.end(), [](const PlannedStage& stage) {
    return stage.num_run > 0 && stage.name == kStereoStage;
  });
}

// Of a job for depth maps; nothing for others.
ReconstructionPtr OpenForJob(const DenseWorkspace& workspace, const StageOptions& stage,
                             const ReconstructionOptions& options, const CommandContext& context) {
  const std::filesystem::path& root = context.job->root;
  const JobOrder order = ReadJobOrder(JobsFolder(root) / context.job->number.batch);
  if (context.job->number.slice >= order.slices.size()) return nullptr;
  std::vector<std::string> names;
  for (const OrderedTask& task : order.slices[context.job->number.slice]) {
    names.push_back(task.name);
  }
  const std::set<std::string> views = ViewsOfStereoTasks(names);
  const std::filesystem::path scene = JobScenePath(root);
  if (views.empty() || !std::filesystem::exists(scene)) return nullptr;
  return ReadJobScene(
      scene, views,
      MakeColmapWorkspaceFiles(workspace, stage.Database(workspace), stage.sources_path), options,
      context.run);
}

}  // namespace

ReconstructionPtr OpenReconstruction(const DenseWorkspace& workspace, const StageOptions& stage,
                                     const ReconstructionOptions& options,
                                     const CommandContext& own_context, PhotoUse photos) {
  const CommandContext context = FindResources(stage.engine, own_context).context;
  ReconstructionOptions seeded = options;
  seeded.seed = context.run.seed;
  if (context.job && photos == PhotoUse::kPixels) {
    if (ReconstructionPtr part = OpenForJob(workspace, stage, seeded, context)) return part;
  }
  LoadSceneOptions load;
  load.mask_folder = stage.mask_path;
  load.alpha_is_mask = stage.alpha_is_mask;
  load.skip_missing_images = stage.skip_missing_images;
  load.check_images = photos == PhotoUse::kPixels;
  load.ignore_distortion = photos == PhotoUse::kNoCamera;
  ReconstructionPtr reconstruction = MakeReconstruction(
      LoadScene(workspace, load),
      MakeColmapWorkspaceFiles(workspace, stage.Database(workspace), stage.sources_path), seeded,
      context.run);
  WarnWithoutMasks(*reconstruction);
  return reconstruction;
}

ReconstructionPtr OpenJoinedReconstruction(const DenseWorkspace& output,
                                           const std::vector<CloudInput>& inputs,
                                           const ReconstructionOptions& options,
                                           const CommandContext& context, PhotoUse photos) {
  JoinedScene joined = LoadJoinedScene(WorkspacesOfModels(inputs), photos == PhotoUse::kNoCamera);
  context.console->Print(ViewNumbersText(inputs, joined.parts));
  ReconstructionOptions seeded = options;
  seeded.seed = context.run.seed;
  return MakeReconstruction(std::move(joined.whole),
                            MakeJoinedWorkspaceFiles(output, inputs, std::move(joined.parts)),
                            seeded, context.run);
}

bool IsWanted(const DenseWorkspace& workspace, const CommandContext& context) {
  if (!context.job) return true;
  std::error_code ignored;
  return std::filesystem::equivalent(workspace.folder, context.job->root, ignored);
}

void RunPlanned(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                std::vector<Task> tasks, const StageOptions& stage,
                const CommandContext& own_context) {
  if (own_context.job) {
    RunJob(workspace.folder, own_context.job->number, tasks, own_context.run);
    return;
  }
  const RunResources resources = FindResources(stage.engine, own_context);
  const CommandContext& context = resources.context;
  RunStore store(workspace.folder, VersionLine());
  const ProcessBytes of_processes = FindProcessBytes(reconstruction, own_context);
  const size_t process_bytes = of_processes.alone;
  const std::unique_ptr<Engine> engine =
      MakeEngine(workspace.folder, stage.engine, resources, of_processes);
  const PlanOptions options = MakePlanOptions(workspace, stage, process_bytes, context);
  RunPlan plan = PlanRun(tasks, options, &store);
  if (MeasureCosts(plan, &tasks)) plan = PlanRun(tasks, options, &store);
  PlanHeader header = MakeHeader(workspace, reconstruction, plan, process_bytes, context);
  header.divisions = DivideStages(*engine, tasks, plan);
  context.console->Print(PhotoNotes(reconstruction) + PlanText(header, plan));
  CheckPlanFits(header, plan, LongestSide(reconstruction));
  if (!stage.ignore_disk_space) {
    const std::optional<Disk> disk = FindDisk(tasks, plan);
    if (disk) CheckPlanFitsDisk(header, plan, disk->free_bytes, LongestSide(reconstruction));
    CheckScratchFits(header, plan, disk);
  }
  if (Matches(plan)) CheckContrast(reconstruction.scene, *reconstruction.images, context.run);
  if (!header.divisions.empty() && RunsStereo(plan)) {
    WriteJobScene(JobScenePath(workspace.folder), reconstruction);
  }
  ConsoleObserver observer(plan, header, context.console);
  RunTasks(tasks, plan, &store, &observer, context.run, engine.get());
  context.console->Print("results\n" + ResultText(tasks, plan));
}

void RunPlannedTasks(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                     std::vector<Task> tasks, const std::filesystem::path& usual_output,
                     const StageOptions& stage, const CommandContext& context) {
  namespace fs = std::filesystem;
  const auto normal = [](const fs::path& path) { return fs::absolute(path).lexically_normal(); };
  const fs::path output = normal(tasks.back().outputs.front());
  if (output != normal(usual_output)) {
    for (Task& task : tasks) task.name += " -> " + output.string();
  }
  RunPlanned(workspace, reconstruction, std::move(tasks), stage, context);
}

void RunPlannedTask(const DenseWorkspace& workspace, const Reconstruction& reconstruction,
                    Task task, const std::filesystem::path& usual_output, const StageOptions& stage,
                    const CommandContext& context) {
  RunPlannedTasks(workspace, reconstruction, {std::move(task)}, usual_output, stage, context);
}

}  // namespace lsmvs
