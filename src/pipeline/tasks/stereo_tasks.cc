#include <fmt/format.h>

#include <algorithm>

#include "lsmvs/image/largest_image.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/tasks/expected_sizes.h"
#include "lsmvs/pipeline/tasks/task_inputs.h"
#include "lsmvs/scene/packed_depth_map.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// Version of the method: a new one makes maps of older runs stale.
constexpr const char* kStereoVersion = "9";
constexpr const char* kFusionVersion = "7";

// Part of the memory budget that cached depth maps may take.
constexpr size_t kMapBudgetDivisor = 4;

std::string KindName(DepthMapKind kind) {
  return kind == DepthMapKind::kPhotometric ? "photometric" : "geometric";
}

// Of the image store, that the maps of a kind have.
int LevelOf(const Reconstruction& reconstruction, DepthMapKind kind) {
  return kind == DepthMapKind::kPhotometric ? PhotometricLevel(reconstruction.options.patch_match)
                                            : 0;
}

// Bytes for cached maps of a kind.
size_t MapBudget(const Reconstruction& reconstruction, DepthMapKind kind) {
  const int level = LevelOf(reconstruction, kind);
  return std::min(reconstruction.memory_budget_bytes / kMapBudgetDivisor,
                  kViewsHeld * PackedDepthMap::kBytesPerPixel *
                      LargestImagePixels(*reconstruction.images, level));
}

// Depth and three components of a normal as floats, and the headers.
uint64_t MapFileBytes(const Reconstruction& reconstruction, int view_idx, DepthMapKind kind) {
  constexpr uint64_t kHeaderBytes = 64;
  const uint64_t bytes_per_pixel =
      reconstruction.options.map_precision == MapPrecision::kExact ? 16 : 2;
  const PinholeCamera camera =
      reconstruction.images->Camera(view_idx, LevelOf(reconstruction, kind));
  return kHeaderBytes + bytes_per_pixel * static_cast<uint64_t>(camera.width) *
                            static_cast<uint64_t>(camera.height);
}

double CountDepths(const DepthMap& map) {
  const auto& depths = map.depth.pixels;
  return static_cast<double>(
      std::count_if(depths.begin(), depths.end(), [](float depth) { return depth > 0; }));
}

void CheckDepthRangeKnown(const Reconstruction& reconstruction) {
  const PatchMatchOptions& options = reconstruction.options.patch_match;
  if (!reconstruction.scene.points.empty()) return;
  if (options.depth_min.has_value() && options.depth_max.has_value()) return;
  throw InputError(reconstruction.files->PointsFile().string(),
                   "holds no points, so that nothing tells how far the scene is",
                   "triangulate points (colmap point_triangulator), or give "
                   "--PatchMatchStereo.depth_min and --PatchMatchStereo.depth_max");
}

// The photometric maps of a view and its neighbours.
void CheckDepthMaps(const Reconstruction& reconstruction, int view_idx) {
  const auto check = [&](int i) {
    reconstruction.files->CheckDepthMap(reconstruction.scene.views[static_cast<size_t>(i)],
                                        DepthMapKind::kPhotometric);
  };
  check(view_idx);
  for (const Neighbor& n : reconstruction.neighbors[static_cast<size_t>(view_idx)]) {
    check(n.view_idx);
  }
}

TaskCounts RunStereo(const Reconstruction& reconstruction, int view_idx, DepthMapKind kind,
                     const TaskRun& run) {
  CheckDepthRangeKnown(reconstruction);
  CheckAnyNeighbors(reconstruction);
  const auto view = static_cast<size_t>(view_idx);
  std::unique_ptr<DepthMapSource> maps;
  if (kind == DepthMapKind::kGeometric) {
    CheckDepthMaps(reconstruction, view_idx);
    maps =
        reconstruction.files->OpenDepthMaps(reconstruction.scene, DepthMapKind::kPhotometric,
                                            MapBudget(reconstruction, DepthMapKind::kPhotometric));
  }
  const DepthMap map =
      EstimateDepthMap(reconstruction.scene, *reconstruction.images, view_idx,
                       reconstruction.neighbors[view], reconstruction.depth_ranges[view],
                       maps.get(), reconstruction.options.patch_match, run.context);
  reconstruction.files->WriteDepthMap(reconstruction.scene.views[view], kind, map,
                                      reconstruction.options.map_precision, run.outputs);
  TrimToViewsHeld(*reconstruction.images);
  return {{"maps", 1.0}, {"depths", CountDepths(map)}};
}

Task MakeStereoTask(const ReconstructionPtr& reconstruction, int view_idx, DepthMapKind kind) {
  const auto view = static_cast<size_t>(view_idx);
  const ReconstructionOptions& options = reconstruction->options;
  Task task;
  task.stage = kStereoStage;
  task.name =
      fmt::format("{}/{}/{}", kStereoStage, KindName(kind), reconstruction->scene.views[view].name);
  task.version = kStereoVersion;
  task.options = TaskOptionsText(*reconstruction, options.view_selection, options.patch_match);
  if (options.map_precision == MapPrecision::kCompact) task.options += "map_format=compact 2\n";
  AddModelInputs(*reconstruction, &task);
  AddPhotoInputs(*reconstruction, view_idx, &task);
  for (const Neighbor& n : reconstruction->neighbors[view]) {
    AddPhotoInputs(*reconstruction, n.view_idx, &task);
  }
  if (kind == DepthMapKind::kGeometric) {
    AddDepthMapInputs(*reconstruction, view_idx, DepthMapKind::kPhotometric, &task);
    for (const Neighbor& n : reconstruction->neighbors[view]) {
      AddDepthMapInputs(*reconstruction, n.view_idx, DepthMapKind::kPhotometric, &task);
    }
  }
  const auto outputs =
      reconstruction->files->DepthMapFiles(reconstruction->scene.views[view], kind);
  task.outputs.assign(outputs.begin(), outputs.end());
  task.foreign_outputs = ForeignOutputs::kUse;
  task.wanted = kind == FinalDepthMaps(options);
  task.temporary = !task.wanted && !options.keep_photometric_maps;
  task.output_bytes = MapFileBytes(*reconstruction, view_idx, kind);
  task.run = [=](const TaskRun& run) { return RunStereo(*reconstruction, view_idx, kind, run); };
  return task;
}

// Spreads the cost of both passes over the views, whose tasks come pass by pass.
void SetCosts(const Reconstruction& reconstruction, std::vector<Task>* tasks) {
  // Of the time, where there are two passes: measured on 8 to 24 photos.
  constexpr double kPhotometricShare = 0.28;
  const CostEstimate cost = EstimatePatchMatchCost(reconstruction.scene, *reconstruction.images,
                                                   reconstruction.options.patch_match);
  const size_t num_views = reconstruction.scene.views.size();
  const bool one_pass = tasks->size() == num_views;
  const double all_pixels = NumPixels(reconstruction);
  for (size_t i = 0; i < tasks->size(); ++i) {
    const PinholeCamera camera = reconstruction.images->Camera(static_cast<int>(i % num_views), 0);
    const double share = one_pass        ? 1.0
                         : i < num_views ? kPhotometricShare
                                         : 1.0 - kPhotometricShare;
    const double pixels = static_cast<double>(camera.width) * camera.height;
    (*tasks)[i].cost = {cost.cpu_seconds * share * pixels / all_pixels, cost.peak_bytes};
  }
}

// Views whose maps are to be fused. Throws InputError if there is none.
std::vector<int> ViewsToFuse(const Reconstruction& reconstruction, DepthMapKind kind,
                             MapsToFuse maps) {
  std::vector<int> views;
  for (int i = 0; i < reconstruction.scene.num_views(); ++i) {
    const View& view = reconstruction.scene.views[static_cast<size_t>(i)];
    const auto depth_map = reconstruction.files->DepthMapFiles(view, kind)[0];
    if (maps == MapsToFuse::kAll || std::filesystem::exists(depth_map)) views.push_back(i);
  }
  if (!views.empty()) return views;
  const auto wanted = reconstruction.files->DepthMapFiles(reconstruction.scene.views.at(0), kind);
  throw InputError(wanted[0].string(), "is missing, and so are the maps of all other images",
                   "run patch_match_stereo first");
}

// Without those that are not there, whose normals come from the depths.
void AddMapsToFuse(const Reconstruction& reconstruction, int view_idx, DepthMapKind kind,
                   MapsToFuse maps, Task* task) {
  const View& view = reconstruction.scene.views[static_cast<size_t>(view_idx)];
  for (const auto& path : reconstruction.files->DepthMapFiles(view, kind)) {
    if (maps == MapsToFuse::kAll || std::filesystem::exists(path)) task->inputs.push_back(path);
  }
}

TaskCounts RunFusion(const Reconstruction& reconstruction, DepthMapKind kind, const TaskRun& run) {
  PrepareStage(reconstruction, run.context);
  for (const View& view : reconstruction.scene.views) {
    reconstruction.files->CheckDepthMap(view, kind);
  }
  const std::unique_ptr<DepthMapSource> maps = reconstruction.files->OpenDepthMaps(
      reconstruction.scene, kind, MapBudget(reconstruction, kind));
  FusionOptions options = reconstruction.options.fusion;
  options.bounding_box = reconstruction.options.bounding_box;
  size_t num_points = 0, num_observations = 0;
  reconstruction.files->WriteCloud(reconstruction.scene, run.outputs, [&](const CloudSink& write) {
    const auto count_and_write = [&](const VisibilityCloud& part) {
      num_points += part.size();
      num_observations += part.view_idxs.size();
      write(part);
    };
    FuseDepthMaps(reconstruction.scene, *reconstruction.images, reconstruction.neighbors, *maps,
                  options, count_and_write, run.context);
    if (num_points > 0) return;
    throw InputError(reconstruction.files->CloudFile().string(),
                     "would be empty: no depth is confirmed by other views",
                     EmptyCloudRemedy(reconstruction) + ", or lower --StereoFusion.min_num_pixels");
  });
  return {{"points", static_cast<double>(num_points)},
          {"observations", static_cast<double>(num_observations)}};
}

}  // namespace

DepthMapKind FinalDepthMaps(const ReconstructionOptions& options) {
  return options.patch_match.geom_consistency ? DepthMapKind::kGeometric
                                              : DepthMapKind::kPhotometric;
}

std::vector<Task> MakeStereoTasks(const ReconstructionPtr& reconstruction) {
  std::vector<Task> tasks;
  const int num_views = reconstruction->scene.num_views();
  for (const DepthMapKind kind : {DepthMapKind::kPhotometric, DepthMapKind::kGeometric}) {
    if (kind == DepthMapKind::kGeometric && kind != FinalDepthMaps(reconstruction->options)) break;
    for (int i = 0; i < num_views; ++i) tasks.push_back(MakeStereoTask(reconstruction, i, kind));
  }
  SetCosts(*reconstruction, &tasks);
  return tasks;
}

Task MakeFusionTask(const ReconstructionPtr& reconstruction, DepthMapKind kind, MapsToFuse maps,
                    const std::filesystem::path& cloud) {
  const ReconstructionOptions& options = reconstruction->options;
  Task task;
  task.stage = task.name = kFusionStage;
  task.version = kFusionVersion;
  task.options = TaskOptionsText(*reconstruction, options.view_selection, options.fusion) +
                 fmt::format("input_type={}\nbounding_box={}\n", KindName(kind),
                             BoxText(options.bounding_box));
  AddModelInputs(*reconstruction, &task);
  AddAllPhotoInputs(*reconstruction, &task);
  for (const int view_idx : ViewsToFuse(*reconstruction, kind, maps)) {
    AddMapsToFuse(*reconstruction, view_idx, kind, maps, &task);
  }
  task.outputs = reconstruction->files->CloudFiles(cloud);
  task.foreign_outputs = ForeignOutputs::kUse;
  task.cost = EstimateFusionCost(reconstruction->scene, *reconstruction->images, options.fusion);
  task.output_bytes =
      ExpectedCloudBytes(*reconstruction, ExpectedPoints(*reconstruction, std::filesystem::path()));
  task.run = [=](const TaskRun& run) { return RunFusion(*reconstruction, kind, run); };
  return task;
}

}  // namespace lsmvs
