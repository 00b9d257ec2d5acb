#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "lsmvs/image/largest_image.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/tasks/expected_sizes.h"
#include "lsmvs/pipeline/tasks/task_inputs.h"
#include "lsmvs/scene/packed_depth_map.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// Version of the method: a new one makes maps of older runs stale.
constexpr const char* kStereoVersion = "9";
constexpr const char* kFusionVersion = "7";

// Views of one task of fusion, at most. The maps and photos of their neighbours are read, too:
// fewer would read more in all. Fixed, so that the tasks are the same on every machine.
constexpr int kViewsOfFusionTask = 10;

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

// Throws InputError if no view has a map to be fused.
void CheckAnyMaps(const Reconstruction& reconstruction, DepthMapKind kind, MapsToFuse maps) {
  const auto& views = reconstruction.scene.views;
  const auto has_map = [&](const View& view) {
    return fs::exists(reconstruction.files->DepthMapFiles(view, kind)[0]);
  };
  if (maps == MapsToFuse::kAll || std::any_of(views.begin(), views.end(), has_map)) return;
  throw InputError(reconstruction.files->DepthMapFiles(views.at(0), kind)[0].string(),
                   "is missing, and so are the maps of all other images",
                   "run patch_match_stereo first");
}

// Without those that are not there, whose normals come from the depths.
void AddMapsToFuse(const Reconstruction& reconstruction, int view_idx, DepthMapKind kind,
                   MapsToFuse maps, Task* task) {
  const View& view = reconstruction.scene.views[static_cast<size_t>(view_idx)];
  const auto files = reconstruction.files->DepthMapFiles(view, kind);
  if (maps == MapsToFuse::kPresent && !fs::exists(files[0])) return;
  for (const fs::path& path : files) {
    if (maps == MapsToFuse::kAll || fs::exists(path)) task->inputs.push_back(path);
  }
}

// What a task of fusion works on.
struct FusionGroup {
  std::vector<int> view_idxs;       // whose pixels give points, ascending
  std::vector<int> view_idxs_read;  // whose maps and photos are read, ascending
};

// All views in their order, as evenly as can be.
std::vector<FusionGroup> FusionGroups(const Reconstruction& reconstruction) {
  const int num_views = reconstruction.scene.num_views();
  const int num_groups = (num_views + kViewsOfFusionTask - 1) / kViewsOfFusionTask;
  const auto neighbors = FusionNeighbors(reconstruction.scene, reconstruction.neighbors,
                                         reconstruction.options.fusion);
  std::vector<FusionGroup> groups;
  for (int g = 0; g < num_groups; ++g) {
    FusionGroup& group = groups.emplace_back();
    std::set<int> read;
    for (int v = g * num_views / num_groups; v < (g + 1) * num_views / num_groups; ++v) {
      group.view_idxs.push_back(v);
      read.insert(v);
      const std::vector<int>& of_view = neighbors[static_cast<size_t>(v)];
      read.insert(of_view.begin(), of_view.end());
    }
    group.view_idxs_read.assign(read.begin(), read.end());
  }
  return groups;
}

// Throws InputError if there is none.
void CheckAnyPoints(const Reconstruction& reconstruction, uint64_t num_points) {
  if (num_points > 0) return;
  throw InputError(reconstruction.files->CloudFile().string(),
                   "would be empty: no depth is confirmed by other views",
                   EmptyCloudRemedy(reconstruction) + ", or lower --StereoFusion.min_num_pixels");
}

TaskCounts CloudTaskCounts(const CloudCounts& counts) {
  return {{"points", static_cast<double>(counts.num_points)},
          {"observations", static_cast<double>(counts.num_observations)}};
}

// Writes the points of a group. `is_all`: there is no other group.
CloudCounts FuseGroup(const Reconstruction& reconstruction, DepthMapKind kind,
                      const FusionGroup& group, bool is_all, const TaskRun& run) {
  PrepareStage(reconstruction, run.context);
  for (const int view_idx : group.view_idxs_read) {
    reconstruction.files->CheckDepthMap(reconstruction.scene.views[static_cast<size_t>(view_idx)],
                                        kind);
  }
  const std::unique_ptr<DepthMapSource> maps = reconstruction.files->OpenDepthMaps(
      reconstruction.scene, kind, MapBudget(reconstruction, kind));
  FusionOptions options = reconstruction.options.fusion;
  options.bounding_box = reconstruction.options.bounding_box;
  CloudCounts counts;
  reconstruction.files->WriteCloud(reconstruction.scene, run.outputs, [&](const CloudSink& write) {
    const auto count_and_write = [&](const VisibilityCloud& part) {
      counts.num_points += part.size();
      counts.num_observations += part.view_idxs.size();
      write(part);
    };
    FuseViews(reconstruction.scene, *reconstruction.images, reconstruction.neighbors, *maps,
              group.view_idxs, options, count_and_write, run.context);
    if (is_all) CheckAnyPoints(reconstruction, counts.num_points);
  });
  return counts;
}

TaskCounts RunJoin(const Reconstruction& reconstruction, const std::vector<fs::path>& parts,
                   const TaskRun& run) {
  const CloudCounts counts =
      reconstruction.files->JoinClouds(reconstruction.scene, parts, run.outputs);
  CheckAnyPoints(reconstruction, counts.num_points);
  return CloudTaskCounts(counts);
}

// With what its result depends on beside the maps and photos of its views.
Task FusionTask(const Reconstruction& reconstruction, DepthMapKind kind, const std::string& name,
                const fs::path& cloud) {
  const ReconstructionOptions& options = reconstruction.options;
  Task task;
  task.stage = kFusionStage;
  task.name = name;
  task.version = kFusionVersion;
  task.options = TaskOptionsText(reconstruction, options.view_selection, options.fusion) +
                 fmt::format("input_type={}\nbounding_box={}\n", KindName(kind),
                             BoxText(options.bounding_box));
  AddModelInputs(reconstruction, &task);
  task.outputs = reconstruction.files->CloudFiles(cloud);
  return task;
}

// Fuses one of several groups.
Task MakeFusionPart(const ReconstructionPtr& reconstruction, DepthMapKind kind, MapsToFuse maps,
                    const FusionGroup& group, int number, const fs::path& cloud) {
  Task task = FusionTask(*reconstruction, kind, fmt::format("{}/part {}", kFusionStage, number),
                         reconstruction->files->CloudPartFile(cloud, number));
  const auto& views = reconstruction->scene.views;
  task.options += fmt::format("first_view={}\nlast_view={}\n",
                              views[static_cast<size_t>(group.view_idxs.front())].name,
                              views[static_cast<size_t>(group.view_idxs.back())].name);
  for (const int view_idx : group.view_idxs_read) {
    AddPhotoInputs(*reconstruction, view_idx, &task);
    AddMapsToFuse(*reconstruction, view_idx, kind, maps, &task);
  }
  task.wanted = false;
  task.temporary = true;
  task.run = [=](const TaskRun& run) {
    FuseGroup(*reconstruction, kind, group, false, run);
    return TaskCounts();
  };
  return task;
}

// Fuses the only group.
Task MakeWholeFusion(const ReconstructionPtr& reconstruction, DepthMapKind kind, MapsToFuse maps,
                     const FusionGroup& group, const fs::path& cloud) {
  Task task = FusionTask(*reconstruction, kind, kFusionStage, cloud);
  AddAllPhotoInputs(*reconstruction, &task);
  for (const int view_idx : group.view_idxs) {
    AddMapsToFuse(*reconstruction, view_idx, kind, maps, &task);
  }
  task.run = [=](const TaskRun& run) {
    return CloudTaskCounts(FuseGroup(*reconstruction, kind, group, true, run));
  };
  return task;
}

// Puts the parts one behind the other.
Task MakeJoinTask(const ReconstructionPtr& reconstruction, DepthMapKind kind,
                  const std::vector<Task>& parts, const fs::path& cloud) {
  Task task = FusionTask(*reconstruction, kind, kFusionStage, cloud);
  std::vector<fs::path> clouds;
  for (const Task& part : parts) {
    clouds.push_back(part.outputs.front());
    task.inputs.insert(task.inputs.end(), part.outputs.begin(), part.outputs.end());
  }
  task.run = [=](const TaskRun& run) { return RunJoin(*reconstruction, clouds, run); };
  return task;
}

// Of the groups' tasks: the cost of all by the pixels of each.
void SetFusionCosts(const Reconstruction& reconstruction, const std::vector<FusionGroup>& groups,
                    uint64_t cloud_bytes, std::vector<Task>* tasks) {
  const CostEstimate cost = EstimateFusionCost(reconstruction.scene, *reconstruction.images,
                                               reconstruction.options.fusion);
  const double all_pixels = NumPixels(reconstruction);
  for (size_t g = 0; g < groups.size(); ++g) {
    double pixels = 0;
    for (const int view_idx : groups[g].view_idxs) {
      const PinholeCamera camera = reconstruction.images->Camera(view_idx, 0);
      pixels += static_cast<double>(camera.width) * camera.height;
    }
    const double share = pixels / all_pixels;
    (*tasks)[g].cost = {cost.cpu_seconds * share, cost.peak_bytes};
    (*tasks)[g].output_bytes = static_cast<uint64_t>(static_cast<double>(cloud_bytes) * share);
  }
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

std::vector<Task> MakeFusionTasks(const ReconstructionPtr& reconstruction, DepthMapKind kind,
                                  MapsToFuse maps, const std::filesystem::path& cloud) {
  // Of the join, which copies files.
  constexpr double kSecondsPerByte = 2e-9;
  constexpr size_t kJoinBytes = 8 << 20;
  CheckAnyMaps(*reconstruction, kind, maps);
  const std::vector<FusionGroup> groups = FusionGroups(*reconstruction);
  const uint64_t cloud_bytes =
      ExpectedCloudBytes(*reconstruction, ExpectedPoints(*reconstruction, std::filesystem::path()));
  std::vector<Task> tasks;
  if (groups.size() == 1) {
    tasks.push_back(MakeWholeFusion(reconstruction, kind, maps, groups.front(), cloud));
  } else {
    int number = 0;
    for (const FusionGroup& group : groups) {
      tasks.push_back(MakeFusionPart(reconstruction, kind, maps, group, ++number, cloud));
    }
    tasks.push_back(MakeJoinTask(reconstruction, kind, tasks, cloud));
    tasks.back().cost = {kSecondsPerByte * static_cast<double>(cloud_bytes), kJoinBytes};
    tasks.back().output_bytes = cloud_bytes;
  }
  SetFusionCosts(*reconstruction, groups, cloud_bytes, &tasks);
  tasks.back().foreign_outputs = ForeignOutputs::kUse;
  return tasks;
}

}  // namespace lsmvs
