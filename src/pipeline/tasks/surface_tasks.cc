#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/tasks/cloud_check.h"
#include "lsmvs/pipeline/tasks/expected_sizes.h"
#include "lsmvs/pipeline/tasks/task_inputs.h"
#include "lsmvs/refinement/refinement_worker.h"
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr const char* kSurfaceVersion = "10";
constexpr const char* kRefinementVersion = "9";

// Points inside the options' box, which is in the world of the files; all if it is empty.
VisibilityCloud Crop(const Reconstruction& reconstruction, VisibilityCloud cloud) {
  const Eigen::AlignedBox3d& box = reconstruction.options.bounding_box;
  if (box.isEmpty()) return cloud;
  const Eigen::Vector3d& world_offset = reconstruction.scene.world_offset;
  cloud.KeepIf(
      [&](size_t p) { return box.contains(cloud.positions[p].cast<double>() + world_offset); });
  return cloud;
}

VisibilityCloud SparseCloud(const Scene& scene) {
  VisibilityCloud cloud;
  for (const SparsePoint& point : scene.points) {
    const std::vector<uint32_t> views(point.view_idxs.begin(), point.view_idxs.end());
    cloud.Add(point.x_in_world.cast<float>(), Eigen::Vector3f::Zero(), point.color, views);
  }
  return cloud;
}

using CloudReader = std::function<VisibilityCloud()>;
// Among the checkpoints.
constexpr const char* kFitFile = "cloud_fit";

// Where MeshCloud's outputs are.
enum SurfaceOutput { kMeshFile, kMeshVisibilityFile, kCloudFile, kCloudVisibilityFile };

VisibilityCloud ReadCroppedCloud(const Reconstruction& reconstruction,
                                 const std::filesystem::path& cloud) {
  return Crop(reconstruction, reconstruction.files->ReadCloud(cloud, reconstruction.scene));
}

// Reads the cloud once more: it was freed when its points were merged.
void WriteFilteredCloud(const Reconstruction& reconstruction,
                        const std::filesystem::path& cloud_path,
                        const std::vector<uint8_t>& point_is_free, const TaskRun& run) {
  const VisibilityCloud cloud = ReadCroppedCloud(reconstruction, cloud_path);
  LSMVS_CHECK_EQ(cloud.size(), point_is_free.size());
  const auto write = [&](const CloudSink& sink) {
    constexpr size_t kPart = 1 << 16;
    VisibilityCloud part;
    for (size_t p = 0; p < cloud.size(); ++p) {
      if (!point_is_free[p]) {
        part.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], cloud.ViewsOf(p));
      }
      if (part.size() < kPart && p + 1 < cloud.size()) continue;
      sink(part);
      part = {};
    }
  };
  reconstruction.files->WriteCloud(
      reconstruction.scene, {run.outputs.at(kCloudFile), run.outputs.at(kCloudVisibilityFile)},
      write);
}

// Of each vertex, 0 to 1: by the number of views that see it.
std::vector<float> QualityByViews(const std::vector<uint64_t>& view_begin, double sigma) {
  std::vector<float> quality;
  for (size_t v = 0; v + 1 < view_begin.size(); ++v) {
    quality.push_back(static_cast<float>(ViewConfidence(view_begin[v + 1] - view_begin[v], sigma)));
  }
  return quality;
}

// The cloud, and how it fits its views, which is put among the checkpoints.
VisibilityCloud ReadAndMeasure(const Scene& scene, const CloudReader& read_cloud,
                               const CheckpointFolder& checkpoints, CloudFit* fit) {
  VisibilityCloud cloud = read_cloud();
  *fit = MeasureCloudFit(scene, cloud);
  checkpoints.Write(kFitFile, std::vector(1, *fit));
  return cloud;
}

// Without checkpoints, the cloud is read first, and the rest of the budget is for the mesher.
VisibilityMesherResult RunMesher(const Scene& scene, const CloudReader& read_cloud,
                                 const VisibilityMesherOptions& options, const TaskRun& run,
                                 CloudFit* fit) {
  constexpr double kPartOfReading = 0.04, kPartUntilWriting = 0.97;
  RunContext context = run.context.Part(kPartOfReading, kPartUntilWriting);
  const CheckpointFolder checkpoints(run.checkpoint_folder);
  const auto read = [&] { return ReadAndMeasure(scene, read_cloud, checkpoints, fit); };
  if (checkpoints.is_on()) {
    VisibilityMesherResult result = MeshVisibilityCloud(scene, read, options, context, checkpoints);
    std::vector<CloudFit> measured;
    checkpoints.Read(kFitFile, &measured);
    *fit = measured.at(0);
    return result;
  }
  VisibilityCloud cloud = read();
  run.context.Report(kPartOfReading);
  const MeshingSize size{.num_points = cloud.size(), .num_view_entries = cloud.view_idxs.size()};
  context.memory_budget_bytes -= std::min(context.memory_budget_bytes, size.CloudBytes());
  return MeshVisibilityCloud(scene, std::move(cloud), options, context);
}

TaskCounts MeshCloud(const Reconstruction& reconstruction, const CloudReader& read_cloud,
                     const std::filesystem::path& cloud_path, const TaskRun& run) {
  const ReconstructionOptions& options = reconstruction.options;
  const Eigen::Vector3d& offset = reconstruction.scene.world_offset;
  VisibilityMesherOptions surface_options = options.surface;
  surface_options.find_free_points = run.outputs.size() > kCloudFile;
  CloudFit fit;
  VisibilityMesherResult result =
      RunMesher(reconstruction.scene, read_cloud, surface_options, run, &fit);
  if (result.mesh.empty()) {
    throw InputError(cloud_path.string(), "gives no surface: " + result.message,
                     "check that the points and their views belong to this model");
  }
  const std::string warning = ContradictionWarning(
      fit, result.counters.num_vertices + result.counters.num_filtered_vertices,
      result.mesh.vertices.size());
  if (!warning.empty()) LOG(WARNING) << cloud_path.string() << ": " << warning;
  result.mesh.vertex_quality =
      QualityByViews(result.view_begin, options.surface.merging.visibility_sigma);
  WriteMeshPly(run.outputs.at(kMeshFile), result.mesh, offset);
  reconstruction.files->WriteVisibility(result.view_begin, result.view_idxs,
                                        run.outputs.at(kMeshVisibilityFile));
  if (surface_options.find_free_points) {
    WriteFilteredCloud(reconstruction, cloud_path, result.point_is_free, run);
  }
  TaskCounts counts = {
      {"points", static_cast<double>(result.counters.num_points)},
      {"delaunay_vertices", static_cast<double>(result.counters.num_vertices)},
      {"filtered_vertices", static_cast<double>(result.counters.num_filtered_vertices)},
      {"cells", static_cast<double>(result.counters.num_cells)},
      {"rays", static_cast<double>(result.counters.rays.num_rays)},
      {"crossings", static_cast<double>(result.counters.rays.num_crossings)},
      {"vertices", static_cast<double>(result.mesh.vertices.size())},
      {"faces", static_cast<double>(result.mesh.faces.size())},
      {"steps_found", static_cast<double>(result.counters.num_steps_found)},
      {"points_inside_share", fit.inside},
      {"normals_facing_share", fit.facing},
      {"predicted_peak_bytes", static_cast<double>(result.predicted_peak_bytes)},
      {"measured_peak_bytes", static_cast<double>(result.measured_peak_bytes)},
  };
  for (const auto& [phase, seconds] : result.seconds) counts[phase + "_seconds"] = seconds;
  return counts;
}

// `views_per_point`: in the mean.
MeshingSize GuessSize(const Reconstruction& reconstruction, size_t num_points,
                      double views_per_point, PointSpacing spacing) {
  const auto num_view_entries =
      static_cast<size_t>(views_per_point * static_cast<double>(num_points));
  return EstimateMeshingSize(reconstruction.scene, num_points, num_view_entries, spacing,
                             reconstruction.options.surface, reconstruction.num_threads);
}

void SetSurfaceCost(const Reconstruction& reconstruction, const MeshingSize& size, Task* task) {
  task->cost = EstimateVisibilityMesherCost(size);
  task->least_bytes = LeastBytes(task->cost.peak_bytes);
  // Where there are many points to a vertex, sorting them takes more than what is kept later.
  const size_t sorting = size.CloudBytes() + size.SortingBytes();
  task->checkpoint_bytes =
      std::max(size.CheckpointBytes(), sorting - std::min(sorting, task->cost.peak_bytes));
  task->output_bytes = ExpectedSurfaceBytes(reconstruction, size.num_vertices);
}

// From a sample of the cloud; whoever reads it will say what is wrong with it.
void MeasureSurfaceCost(const Reconstruction& reconstruction, const std::filesystem::path& cloud,
                        Task* task) {
  Eigen::AlignedBox3d box = reconstruction.options.bounding_box;
  if (!box.isEmpty()) box.translate(-reconstruction.scene.world_offset);
  CloudSampler sampler(reconstruction.scene, box);
  try {
    reconstruction.files->SampleCloud(cloud, reconstruction.scene, &sampler);
  } catch (const InputError&) {
    return;
  }
  const CloudSample sample = sampler.Take();
  if (sample.places.empty()) return;
  SetSurfaceCost(reconstruction,
                 MeasureMeshingSize(reconstruction.scene, sample, reconstruction.options.surface,
                                    reconstruction.num_threads),
                 task);
}

Task SurfaceTask(const Reconstruction& reconstruction, const std::filesystem::path& mesh) {
  const ReconstructionOptions& options = reconstruction.options;
  Task task;
  task.stage = task.name = kSurfaceStage;
  task.version = kSurfaceVersion;
  task.options = TaskOptionsText(reconstruction, options.surface) +
                 fmt::format("bounding_box={}\n", BoxText(options.bounding_box));
  AddModelInputs(reconstruction, &task);
  task.outputs = reconstruction.files->VisibleMeshFiles(mesh);
  return task;
}

TaskCounts RunRefinement(const Reconstruction& reconstruction, const std::filesystem::path& input,
                         const TaskRun& run) {
  PrepareStage(reconstruction, run.context);
  const Eigen::Vector3d& offset = reconstruction.scene.world_offset;
  TriangleMesh mesh = ReadMeshPly(input, offset);
  if (mesh.empty()) throw InputError(input.string(), "has no faces", "give a mesh");
  const RefinementResult result = RefineMesh(reconstruction.scene, *reconstruction.images,
                                             std::move(mesh), reconstruction.options.refinement,
                                             run.context, CheckpointFolder(run.checkpoint_folder));
  WriteMeshPly(run.outputs.at(0), result.mesh, offset);
  return {{"vertices", static_cast<double>(result.mesh.vertices.size())},
          {"faces", static_cast<double>(result.mesh.faces.size())},
          {"faces_refined", static_cast<double>(result.num_faces_refined)},
          {"pairs", static_cast<double>(result.num_pairs)},
          {"steps_found", static_cast<double>(result.num_steps_found)},
          {"photo_error_before", result.input_photo_error},
          {"photo_error_after", result.output_photo_error},
          {"prepare_seconds", result.prepare_seconds},
          {"filter_seconds", result.filter_seconds},
          {"remesh_seconds", result.remesh_seconds},
          {"optimize_seconds", result.optimize_seconds},
          {"guard_seconds", result.guard_seconds},
          {"simplify_seconds", result.simplify_seconds},
          {"color_seconds", result.color_seconds}};
}

}  // namespace

Task MakeSurfaceTask(const ReconstructionPtr& reconstruction, const std::filesystem::path& cloud,
                     const std::filesystem::path& mesh,
                     const std::filesystem::path& filtered_cloud) {
  Task task = SurfaceTask(*reconstruction, mesh);
  if (!filtered_cloud.empty()) {
    for (const auto& file : reconstruction->files->CloudFiles(filtered_cloud)) {
      task.outputs.push_back(file);
    }
  }
  const auto inputs = reconstruction->files->CloudFiles(cloud);
  task.inputs.insert(task.inputs.end(), inputs.begin(), inputs.end());
  SetSurfaceCost(*reconstruction,
                 GuessSize(*reconstruction, ExpectedPoints(*reconstruction, cloud),
                           ExpectedViewsPerPoint(*reconstruction), ExpectedSpacing(cloud)),
                 &task);
  task.measure_cost = [=](Task* measured) { MeasureSurfaceCost(*reconstruction, cloud, measured); };
  task.run = [=](const TaskRun& run) {
    PrepareStage(*reconstruction, run.context);
    return MeshCloud(
        *reconstruction, [&] { return ReadCroppedCloud(*reconstruction, cloud); }, cloud, run);
  };
  return task;
}

Task MakeSparseSurfaceTask(const ReconstructionPtr& reconstruction,
                           const std::filesystem::path& mesh) {
  Task task = SurfaceTask(*reconstruction, mesh);
  task.options += "input_type=sparse\n";
  SetSurfaceCost(*reconstruction,
                 GuessSize(*reconstruction, reconstruction->scene.points.size(),
                           MeanTrackLength(reconstruction->scene), PointSpacing::kRandom),
                 &task);
  task.run = [=](const TaskRun& run) {
    PrepareStage(*reconstruction, run.context);
    return MeshCloud(
        *reconstruction, [&] { return Crop(*reconstruction, SparseCloud(reconstruction->scene)); },
        reconstruction->files->PointsFile(), run);
  };
  return task;
}

Task MakeRefinementTask(const ReconstructionPtr& reconstruction,
                        const std::filesystem::path& input_mesh,
                        const std::filesystem::path& output_mesh) {
  const ReconstructionOptions& options = reconstruction->options;
  Task task;
  task.stage = task.name = kRefinementStage;
  task.version = kRefinementVersion;
  task.options = TaskOptionsText(*reconstruction, options.refinement);
  AddModelInputs(*reconstruction, &task);
  AddAllPhotoInputs(*reconstruction, &task);
  task.inputs.push_back(input_mesh);
  task.outputs = {output_mesh};
  RunContext context(reconstruction->num_threads);
  context.memory_budget_bytes = reconstruction->memory_budget_bytes;
  const size_t num_faces = ExpectedFaces(*reconstruction, input_mesh);
  task.cost = EstimateRefinementCost(reconstruction->scene, *reconstruction->images, num_faces,
                                     options.refinement, context);
  task.least_bytes = LeastRefinementBytes(*reconstruction->images, num_faces, task.cost.peak_bytes,
                                          reconstruction->num_threads);
  task.checkpoint_bytes = RefinementCheckpointBytes(num_faces, options.refinement);
  task.output_bytes = ExpectedRefinedBytes(num_faces);
  task.run = [=](const TaskRun& run) { return RunRefinement(*reconstruction, input_mesh, run); };
  // Each helper should have some views for every step.
  constexpr size_t kViewsOfHelper = 4;
  task.max_helpers = reconstruction->scene.views.size() / kViewsOfHelper;
  task.make_worker = [=](const RunContext& worker_context) {
    PrepareStage(*reconstruction, worker_context);
    return MakeRefinementWorker(reconstruction->scene, *reconstruction->images,
                                reconstruction->options.refinement, worker_context);
  };
  return task;
}

}  // namespace lsmvs
