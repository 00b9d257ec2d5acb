#include "lsmvs/pipeline/reconstruction.h"

#include <algorithm>

#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {
// Part of the memory budget that decoded photos may take.
constexpr size_t kImageBudgetDivisor = 4;
}  // namespace

std::shared_ptr<const Reconstruction> MakeReconstruction(
    Scene scene, std::shared_ptr<const WorkspaceFiles> files, const ReconstructionOptions& options,
    const RunContext& context) {
  RequireValid(options);
  auto reconstruction = std::make_shared<Reconstruction>();
  reconstruction->scene = std::move(scene);
  reconstruction->files = std::move(files);
  reconstruction->options = options;
  reconstruction->memory_budget_bytes = context.memory_budget_bytes;
  reconstruction->num_threads = context.num_threads();
  reconstruction->images = MakeImageStore(reconstruction->scene, ImageOptionsOf(options, context));
  reconstruction->neighbors =
      SelectNeighbors(reconstruction->scene, options.view_selection, context);
  const std::vector<SourceRule> rules =
      reconstruction->files->ReadSourceRules(reconstruction->scene);
  reconstruction->has_source_rules =
      !ChangeNothing(rules, options.view_selection.max_num_neighbors);
  ApplySourceRules(reconstruction->scene, rules, &reconstruction->neighbors);
  reconstruction->depth_ranges = EstimateDepthRanges(reconstruction->scene);
  return reconstruction;
}

ImageStoreOptions ImageOptionsOf(const ReconstructionOptions& options, const RunContext& context) {
  ImageStoreOptions photos;
  photos.max_image_size = options.max_image_size;
  photos.budget_bytes = context.memory_budget_bytes / kImageBudgetDivisor;
  return photos;
}

std::vector<Task> MakeReconstructionTasks(const ReconstructionPtr& reconstruction,
                                          ReconstructionStage from, ReconstructionStage to) {
  CheckStages(reconstruction->options.point_source, from, to);
  const WorkspaceFiles& files = *reconstruction->files;
  const bool quasi_dense = reconstruction->options.point_source == PointSource::kQuasiDense;
  const auto included = [&](ReconstructionStage stage) { return from <= stage && stage <= to; };
  std::vector<Task> tasks;
  if (quasi_dense && included(ReconstructionStage::kQuasiDense)) {
    tasks.push_back(MakeQuasiDenseTask(reconstruction, files.CloudFile()));
  }
  if (!quasi_dense && included(ReconstructionStage::kStereo)) {
    tasks = MakeStereoTasks(reconstruction);
    // Depth maps serve fusion: with a fused.ply that is used as it is, nobody asks for them.
    const bool wanted = to == ReconstructionStage::kStereo;
    for (Task& task : tasks) task.wanted = task.wanted && wanted;
  }
  if (!quasi_dense && included(ReconstructionStage::kFusion)) {
    const MapsToFuse maps = tasks.empty() ? MapsToFuse::kPresent : MapsToFuse::kAll;
    const std::vector<Task> fusion = MakeFusionTasks(
        reconstruction, FinalDepthMaps(reconstruction->options), maps, files.CloudFile());
    tasks.insert(tasks.end(), fusion.begin(), fusion.end());
  }
  if (included(ReconstructionStage::kSurface)) {
    tasks.push_back(MakeSurfaceTask(reconstruction, files.CloudFile(), files.VisibilityMeshFile()));
  }
  if (included(ReconstructionStage::kRefinement)) {
    tasks.push_back(
        MakeRefinementTask(reconstruction, files.VisibilityMeshFile(), files.RefinedMeshFile()));
  }
  if (included(ReconstructionStage::kTexturing)) {
    tasks.push_back(
        MakeTexturingTask(reconstruction, files.RefinedMeshFile(), files.TexturedMeshFile()));
  }
  return tasks;
}

void PrepareStage(const Reconstruction& reconstruction, const RunContext& context) {
  reconstruction.images->Trim(0);
  reconstruction.images->SetBudget(context.memory_budget_bytes / kImageBudgetDivisor);
  ReturnFreedMemory();
}

double NumPixels(const Reconstruction& reconstruction) {
  double pixels = 0;
  for (int i = 0; i < reconstruction.scene.num_views(); ++i) {
    const PinholeCamera camera = reconstruction.images->Camera(i, 0);
    pixels += static_cast<double>(camera.width) * camera.height;
  }
  return pixels;
}

}  // namespace lsmvs
