#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/task_inputs.h"
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr const char* kSurfaceVersion = "7";
constexpr const char* kRefinementVersion = "3";

// Before there is a cloud: points that fusion makes of a pixel, and views of a point; measured on
// scenes of 8 to 24 photos.
constexpr double kPointsPerPixel = 0.25;
constexpr size_t kViewsPerPoint = 4;
constexpr size_t kFacesPerVertex = 2;

// Nothing if there is no such file or it is not a PLY file: whoever reads it will say so.
std::optional<size_t> ElementCount(const std::filesystem::path& path, const std::string& element) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const PlyReader reader(path);
    const PlyElement* found = reader.FindElement(element);
    return found == nullptr ? 0 : found->count;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// Points of the cloud if it is there, else what is to be expected.
size_t ExpectedPoints(const Reconstruction& reconstruction, const std::filesystem::path& cloud) {
  if (const auto count = ElementCount(cloud, "vertex")) return *count;
  return static_cast<size_t>(kPointsPerPixel * NumPixels(reconstruction));
}

size_t ExpectedFaces(const Reconstruction& reconstruction, const std::filesystem::path& mesh) {
  if (const auto count = ElementCount(mesh, "face")) return *count;
  return kFacesPerVertex * EstimateVisibilityMesherVertices(
                               ExpectedPoints(reconstruction, reconstruction.files->CloudFile()),
                               NumPixels(reconstruction), reconstruction.options.surface);
}

// Points inside the box, which is in the world of the files.
VisibilityCloud Crop(const VisibilityCloud& cloud, const Eigen::AlignedBox3d& box,
                     const Eigen::Vector3d& world_offset) {
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

TaskCounts MeshCloud(const Reconstruction& reconstruction, VisibilityCloud cloud,
                     const std::filesystem::path& cloud_path, const TaskRun& run) {
  const ReconstructionOptions& options = reconstruction.options;
  const Eigen::Vector3d& offset = reconstruction.scene.world_offset;
  if (!options.bounding_box.isEmpty()) cloud = Crop(cloud, options.bounding_box, offset);
  const size_t num_points = cloud.size();
  RunContext context = run.context;  // whose budget is for the cloud, too
  const MeshingSize size{.num_points = cloud.size(), .num_view_entries = cloud.view_idxs.size()};
  context.memory_budget_bytes -= std::min(context.memory_budget_bytes, size.CloudBytes());
  const VisibilityMesherResult result =
      MeshVisibilityCloud(reconstruction.scene, std::move(cloud), options.surface, context);
  if (result.mesh.empty()) {
    throw InputError(cloud_path.string(), "gives no surface: " + result.message,
                     "check that the points and their views belong to this model");
  }
  WriteMeshPly(run.outputs.at(0), result.mesh, offset);
  reconstruction.files->WriteVisibility(result.view_begin, result.view_idxs, run.outputs.at(1));
  TaskCounts counts = {
      {"points", static_cast<double>(num_points)},
      {"delaunay_vertices", static_cast<double>(result.counters.num_vertices)},
      {"cells", static_cast<double>(result.counters.num_cells)},
      {"rays", static_cast<double>(result.counters.num_rays)},
      {"crossings", static_cast<double>(result.counters.num_crossings)},
      {"vertices", static_cast<double>(result.mesh.vertices.size())},
      {"faces", static_cast<double>(result.mesh.faces.size())},
      {"predicted_peak_bytes", static_cast<double>(result.predicted_peak_bytes)},
      {"measured_peak_bytes", static_cast<double>(result.measured_peak_bytes)},
  };
  for (const auto& [phase, seconds] : result.seconds) counts[phase + "_seconds"] = seconds;
  return counts;
}

CostEstimate SurfaceCost(const Reconstruction& reconstruction, size_t num_points) {
  return EstimateVisibilityMesherCost(num_points, kViewsPerPoint * num_points,
                                      NumPixels(reconstruction), reconstruction.options.surface);
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
                     const std::filesystem::path& mesh) {
  Task task = SurfaceTask(*reconstruction, mesh);
  const auto inputs = reconstruction->files->CloudFiles(cloud);
  task.inputs.insert(task.inputs.end(), inputs.begin(), inputs.end());
  const size_t num_points = ExpectedPoints(*reconstruction, cloud);
  task.cost = SurfaceCost(*reconstruction, num_points);
  task.run = [=](const TaskRun& run) {
    VisibilityCloud points = reconstruction->files->ReadCloud(cloud, reconstruction->scene);
    return MeshCloud(*reconstruction, std::move(points), cloud, run);
  };
  return task;
}

Task MakeSparseSurfaceTask(const ReconstructionPtr& reconstruction,
                           const std::filesystem::path& mesh) {
  Task task = SurfaceTask(*reconstruction, mesh);
  task.options += "input_type=sparse\n";
  task.cost = SurfaceCost(*reconstruction, reconstruction->scene.points.size());
  task.run = [=](const TaskRun& run) {
    return MeshCloud(*reconstruction, SparseCloud(reconstruction->scene),
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
  RunContext context(1);
  context.memory_budget_bytes = reconstruction->memory_budget_bytes;
  task.cost = EstimateRefinementCost(reconstruction->scene, *reconstruction->images,
                                     ExpectedFaces(*reconstruction, input_mesh), options.refinement,
                                     context);
  task.run = [=](const TaskRun& run) { return RunRefinement(*reconstruction, input_mesh, run); };
  return task;
}

}  // namespace lsmvs
