#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <optional>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/pipeline/cloud_check.h"
#include "lsmvs/pipeline/expected_sizes.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/task_inputs.h"
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr const char* kSurfaceVersion = "8";
constexpr const char* kRefinementVersion = "5";

// Points inside the options' box, which is in the world of the files; all if it is empty.
VisibilityCloud Crop(const Reconstruction& reconstruction, VisibilityCloud cloud) {
  const Eigen::AlignedBox3d& box = reconstruction.options.bounding_box;
  if (box.isEmpty()) return cloud;
  const Eigen::Vector3d& world_offset = reconstruction.scene.world_offset;
  VisibilityCloud kept;
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (!box.contains(cloud.positions[p].cast<double>() + world_offset)) continue;
    kept.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], cloud.ViewsOf(p));
  }
  return kept;
}

VisibilityCloud SparseCloud(const Scene& scene) {
  VisibilityCloud cloud;
  for (const SparsePoint& point : scene.points) {
    const std::vector<uint32_t> views(point.view_idxs.begin(), point.view_idxs.end());
    cloud.Add(point.x_in_world.cast<float>(), Eigen::Vector3f::Zero(), point.color, views);
  }
  return cloud;
}

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

TaskCounts MeshCloud(const Reconstruction& reconstruction, VisibilityCloud cloud,
                     const std::filesystem::path& cloud_path, const TaskRun& run) {
  const ReconstructionOptions& options = reconstruction.options;
  const Eigen::Vector3d& offset = reconstruction.scene.world_offset;
  const size_t num_points = cloud.size();
  const CloudFit fit = MeasureCloudFit(reconstruction.scene, cloud);
  constexpr double kPartOfReading = 0.04, kPartUntilWriting = 0.97;
  run.context.Report(kPartOfReading);
  // Whose budget is for the cloud, too.
  RunContext context = run.context.Part(kPartOfReading, kPartUntilWriting);
  const MeshingSize size{.num_points = cloud.size(), .num_view_entries = cloud.view_idxs.size()};
  context.memory_budget_bytes -= std::min(context.memory_budget_bytes, size.CloudBytes());
  VisibilityMesherOptions surface_options = options.surface;
  surface_options.find_free_points = run.outputs.size() > kCloudFile;
  VisibilityMesherResult result =
      MeshVisibilityCloud(reconstruction.scene, std::move(cloud), surface_options, context);
  if (result.mesh.empty()) {
    throw InputError(cloud_path.string(), "gives no surface: " + result.message,
                     "check that the points and their views belong to this model");
  }
  const std::string warning =
      ContradictionWarning(fit, result.counters.num_vertices, result.mesh.vertices.size());
  if (!warning.empty()) LOG(WARNING) << cloud_path.string() << ": " << warning;
  result.mesh.vertex_quality = QualityByViews(result.view_begin, options.surface.visibility_sigma);
  WriteMeshPly(run.outputs.at(kMeshFile), result.mesh, offset);
  reconstruction.files->WriteVisibility(result.view_begin, result.view_idxs,
                                        run.outputs.at(kMeshVisibilityFile));
  if (surface_options.find_free_points) {
    WriteFilteredCloud(reconstruction, cloud_path, result.point_is_free, run);
  }
  TaskCounts counts = {
      {"points", static_cast<double>(num_points)},
      {"delaunay_vertices", static_cast<double>(result.counters.num_vertices)},
      {"cells", static_cast<double>(result.counters.num_cells)},
      {"rays", static_cast<double>(result.counters.num_rays)},
      {"crossings", static_cast<double>(result.counters.num_crossings)},
      {"vertices", static_cast<double>(result.mesh.vertices.size())},
      {"faces", static_cast<double>(result.mesh.faces.size())},
      {"points_inside_share", fit.inside},
      {"normals_facing_share", fit.facing},
      {"predicted_peak_bytes", static_cast<double>(result.predicted_peak_bytes)},
      {"measured_peak_bytes", static_cast<double>(result.measured_peak_bytes)},
  };
  for (const auto& [phase, seconds] : result.seconds) counts[phase + "_seconds"] = seconds;
  return counts;
}

// `views_per_point`: in the mean.
void SetSurfaceCost(const Reconstruction& reconstruction, size_t num_points, double views_per_point,
                    PointSpacing spacing, Task* task) {
  const auto num_view_entries =
      static_cast<size_t>(views_per_point * static_cast<double>(num_points));
  task->cost =
      EstimateVisibilityMesherCost(reconstruction.scene, num_points, num_view_entries, spacing,
                                   reconstruction.options.surface, reconstruction.num_threads);
  task->least_bytes = LeastBytes(task->cost.peak_bytes);
  task->output_bytes = ExpectedSurfaceBytes(reconstruction, num_points, spacing);
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
  DropCaches(reconstruction);
  const Eigen::Vector3d& offset = reconstruction.scene.world_offset;
  TriangleMesh mesh = ReadMeshPly(input, offset);
  if (mesh.empty()) throw InputError(input.string(), "has no faces", "give a mesh");
  const RefinementResult result =
      RefineMesh(reconstruction.scene, *reconstruction.images, std::move(mesh),
                 reconstruction.options.refinement, run.context);
  WriteMeshPly(run.outputs.at(0), result.mesh, offset);
  return {{"vertices", static_cast<double>(result.mesh.vertices.size())},
          {"faces", static_cast<double>(result.mesh.faces.size())},
          {"faces_refined", static_cast<double>(result.num_faces_refined)},
          {"pairs", static_cast<double>(result.num_pairs)},
          {"photo_error_before", result.input_photo_error},
          {"photo_error_after", result.output_photo_error}};
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
  SetSurfaceCost(*reconstruction, ExpectedPoints(*reconstruction, cloud),
                 ExpectedViewsPerPoint(*reconstruction), ExpectedSpacing(cloud), &task);
  task.run = [=](const TaskRun& run) {
    DropCaches(*reconstruction);
    return MeshCloud(*reconstruction, ReadCroppedCloud(*reconstruction, cloud), cloud, run);
  };
  return task;
}

Task MakeSparseSurfaceTask(const ReconstructionPtr& reconstruction,
                           const std::filesystem::path& mesh) {
  Task task = SurfaceTask(*reconstruction, mesh);
  task.options += "input_type=sparse\n";
  SetSurfaceCost(*reconstruction, reconstruction->scene.points.size(),
                 MeanTrackLength(reconstruction->scene), PointSpacing::kRandom, &task);
  task.run = [=](const TaskRun& run) {
    DropCaches(*reconstruction);
    return MeshCloud(*reconstruction, Crop(*reconstruction, SparseCloud(reconstruction->scene)),
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
  task.least_bytes = LeastBytes(task.cost.peak_bytes);
  task.output_bytes = ExpectedRefinedBytes(num_faces);
  task.run = [=](const TaskRun& run) { return RunRefinement(*reconstruction, input_mesh, run); };
  return task;
}

}  // namespace lsmvs
