#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/commands/evaluation_input.h"
#include "lsmvs/cli/mesh_memory.h"
#include "lsmvs/cli/output_check.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/refinement/vertex_pixel_sizes.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

constexpr double kDefaultErrorPx = 0.25;
// Rounding of a coordinate to single precision, relative.
constexpr double kFloatRounding = 6e-8;

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

constexpr MeshMemoryModel kMemory = {.all = 310, .in_memory = 0, .in_any_order = true};

class MeshSimplifier : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info;
    info.name = "mesh_simplifier";
    info.summary = "Mesh -> mesh with fewer faces, within a distance of it";
    info.details =
        "Collapses edges in the order of their quadric error while the two surfaces stay within "
        "--MeshSimplification.max_error of each other: pixels of the photo that sees the place "
        "finest with --workspace_path (default 0.25), else the unit of the file. Borders stay "
        "within it, too; what is manifold stays manifold. With a target ratio alone nothing bounds "
        "the error.\n"
        "Vertices keep their colours; if INPUT.vis is there, OUTPUT.vis gets the views of the "
        "nearest vertex of the input. Arguments are those of COLMAP's mesh_simplifier, but for "
        "max_error, which is a distance here.";
    info.examples = {
        "lsmvs mesh_simplifier --input_path meshed-visibility.ply --output_path simple.ply "
        "--workspace_path project/dense/0",
        "lsmvs mesh_simplifier --input_path mesh.ply --output_path simple.ply "
        "--MeshSimplification.max_error 0.01 --MeshSimplification.target_face_ratio 0.1"};
    info.required = {"input_path", "output_path"};
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &input_path_, "The mesh to simplify (PLY).");
    options->Add("output_path", &output_path_, "The mesh to write (PLY).");
    options->Add("workspace_path", &workspace_path_,
                 "Workspace with the cameras: errors are then in pixels.");
    options->Add("overwrite", &overwrite_, "Replace the output if it is there.");
    options->Add("MeshSimplification.max_error", &max_error_,
                 "Largest distance between the surfaces, in pixels with --workspace_path, else in "
                 "the unit of the file.",
                 {0.0, 1e30});
    DescribeMeshScratch(&scratch_path_, options);
    options_.Describe(options);
  }

  void Run(const CommandContext& context) override {
    CheckOptions();
    const MeshMemory memory("mesh_simplifier", {input_path_}, kMemory, scratch_path_, context);
    if (!workspace_path_.empty()) scene_ = LoadSceneToEvaluate(workspace_path_, false);
    ReadMesh();
    const std::optional<PointViews> views = ReadViews();
    context.display->Begin("Simplifying");
    const SimplifiedMesh result =
        SimplifyWithinTolerance(mesh_, Tolerance(context.run), options_, context.run);
    context.display->End();
    Write(result, views);
    fmt::print("{} of {} faces\n{}\n", result.mesh.faces.size(), mesh_.faces.size(), output_path_);
  }

 private:
  void CheckOptions() const {
    if (workspace_path_.empty() && !max_error_ && options_.target_face_ratio == 0) {
      throw UsageError(
          "give --workspace_path, --MeshSimplification.max_error or "
          "--MeshSimplification.target_face_ratio; see --help");
    }
    RefuseToReplace({output_path_, DenseWorkspace::VisibilityPath(output_path_)}, overwrite_);
  }

  // About an origin at which its coordinates and single precision do for the error.
  void ReadMesh() {
    if (scene_) offset_ = scene_->world_offset;
    mesh_ = ReadMeshPly(input_path_, offset_);
    if (mesh_.faces.empty()) throw InputError(input_path_, "has no faces", "give a mesh");
    double largest = 0;
    for (const Eigen::Vector3d& x : mesh_.vertices) {
      largest = std::max(largest, x.cwiseAbs().maxCoeff());
    }
    if (scene_ || !max_error_ || largest * kFloatRounding < 0.01 * *max_error_) return;
    offset_ = mesh_.vertices[0];
    mesh_ = ReadMeshPly(input_path_, offset_);
  }

  std::optional<PointViews> ReadViews() const {
    const fs::path path = DenseWorkspace::VisibilityPath(input_path_);
    if (!fs::exists(path)) return std::nullopt;
    return ReadVisibility(path, mesh_.vertices.size());
  }

  std::vector<double> Tolerance(const RunContext& context) const {
    if (!scene_ || (!max_error_ && options_.target_face_ratio > 0)) {
      Eigen::AlignedBox3d box;
      for (const Eigen::Vector3d& x : mesh_.vertices) box.extend(x);
      return std::vector<double>(mesh_.vertices.size(), max_error_.value_or(box.diagonal().norm()));
    }
    std::vector<PosedCamera> views;
    for (const View& view : scene_->views) views.push_back({view.camera, view.cam_from_world});
    std::vector<double> tolerance = VertexPixelSizes(mesh_, views, context);
    for (double& t : tolerance) t *= max_error_.value_or(kDefaultErrorPx);
    return tolerance;
  }

  void Write(const SimplifiedMesh& result, const std::optional<PointViews>& views) const {
    const fs::path vis_path = DenseWorkspace::VisibilityPath(output_path_);
    fs::remove(vis_path);  // of a mesh that was here
    WriteMeshPly(output_path_, result.mesh, offset_);
    if (!views) return;
    const PointViews taken = TakeViews(*views, result.source_vertex);
    WriteVisibility(vis_path, taken.begin, taken.view_idxs);
  }

  std::string scratch_path_, input_path_, output_path_, workspace_path_;
  bool overwrite_ = false;
  std::optional<double> max_error_;
  BoundedSimplificationOptions options_;

  std::optional<Scene> scene_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  TriangleMesh mesh_;
};

}  // namespace

std::unique_ptr<Command> MakeMeshSimplifier() { return std::make_unique<MeshSimplifier>(); }

}  // namespace lsmvs
