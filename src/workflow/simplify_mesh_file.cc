#include "lsmvs/workflow/simplify_mesh_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/refinement/vertex_pixel_sizes.h"
#include "lsmvs/util/error.h"
#include "lsmvs/workflow/files/mesh_memory.h"
#include "lsmvs/workflow/files/mesh_with_views.h"
#include "lsmvs/workflow/files/output_check.h"
#include "lsmvs/workflow/files/scene_input.h"

namespace lsmvs {

namespace {

constexpr MeshMemoryModel kMemory = {.all = 310, .in_memory = 0, .in_any_order = true};

constexpr double kDefaultErrorPx = 0.25;
// Rounding of a coordinate to single precision, relative.
constexpr double kFloatRounding = 6e-8;

// A mesh, less the origin at which its coordinates and single precision do for the error.
struct ShiftedMesh {
  TriangleMesh mesh;
  Eigen::Vector3d offset;
};

ShiftedMesh ReadMesh(const MeshSimplificationOptions& options, const std::optional<Scene>& scene) {
  const Eigen::Vector3d offset = WorldOffset(scene);
  TriangleMesh mesh = ReadMeshPly(options.input_path, offset);
  if (mesh.faces.empty()) throw InputError(options.input_path, "has no faces", "give a mesh");
  double largest = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    largest = std::max(largest, x.cwiseAbs().maxCoeff());
  }
  const bool is_fine =
      scene || !options.max_error || largest * kFloatRounding < 0.01 * *options.max_error;
  if (is_fine) return {std::move(mesh), offset};
  const Eigen::Vector3d origin = mesh.vertices[0];
  return {ReadMeshPly(options.input_path, origin), origin};
}

// How far the surface may be from each vertex.
std::vector<double> Tolerance(const TriangleMesh& mesh, const std::optional<Scene>& scene,
                              const MeshSimplificationOptions& options, const RunContext& context) {
  const std::optional<double>& max_error = options.max_error;
  if (!scene || (!max_error && options.simplification.target_face_ratio > 0)) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : mesh.vertices) box.extend(x);
    return std::vector<double>(mesh.vertices.size(), max_error.value_or(box.diagonal().norm()));
  }
  std::vector<PosedCamera> views;
  for (const View& view : scene->views) views.push_back({view.camera, view.cam_from_world});
  std::vector<double> tolerance = VertexPixelSizes(mesh, views, context);
  for (double& t : tolerance) t *= max_error.value_or(kDefaultErrorPx);
  return tolerance;
}

PointViews TakeViews(const PointViews& views, const std::vector<int>& points) {
  PointViews taken;
  taken.begin = {0};
  for (const int p : points) {
    const auto begin = views.view_idxs.begin();
    const size_t point = static_cast<size_t>(p);
    taken.view_idxs.insert(taken.view_idxs.end(),
                           begin + static_cast<std::ptrdiff_t>(views.begin[point]),
                           begin + static_cast<std::ptrdiff_t>(views.begin[point + 1]));
    taken.begin.push_back(taken.view_idxs.size());
  }
  return taken;
}

void Check(const MeshSimplificationOptions& options) {
  if (options.workspace_path.empty() && !options.max_error &&
      options.simplification.target_face_ratio == 0) {
    throw UsageError(
        "give --workspace_path, --MeshSimplification.max_error or "
        "--MeshSimplification.target_face_ratio; see --help");
  }
  RefuseToReplace(MeshWithViewsFiles(options.output_path), options.overwrite);
}

}  // namespace

void MeshSimplificationOptions::Describe(OptionSet* options) {
  options->Add("input_path", &input_path, "The mesh to simplify (PLY).");
  options->Add("output_path", &output_path, "The mesh to write (PLY).");
  options->Add("workspace_path", &workspace_path,
               "Workspace with the cameras: errors are then in pixels.");
  options->Add("overwrite", &overwrite, "Replace the output if it is there.");
  options->Add("MeshSimplification.max_error", &max_error,
               "Largest distance between the surfaces, in pixels with --workspace_path, else in "
               "the unit of the file.",
               {0.0, 1e30});
  DescribeMeshScratch(&scratch_path, options);
  simplification.Describe(options);
}

void SimplifyMeshFile(const MeshSimplificationOptions& options, const CommandContext& context) {
  Check(options);
  const MeshMemory memory("mesh_simplifier", {options.input_path}, kMemory, options.scratch_path,
                          context);
  const std::optional<Scene> scene = LoadSceneIfGiven(options.workspace_path, false);
  const auto [mesh, offset] = ReadMesh(options, scene);
  std::optional<PointViews> views = ReadViewsOf(options.input_path, mesh.vertices.size());
  context.console->Begin("Simplifying");
  const SimplifiedMesh result = SimplifyWithinTolerance(
      mesh, Tolerance(mesh, scene, options, context.run), options.simplification, context.run);
  context.console->End();
  if (views) views = TakeViews(*views, result.source_vertex);
  WriteMeshWithViews(options.output_path, result.mesh, offset, views);
  context.console->Print(fmt::format("{} of {} faces\n{}\n", result.mesh.faces.size(),
                                     mesh.faces.size(), options.output_path));
}

}  // namespace lsmvs
