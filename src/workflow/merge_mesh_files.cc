#include "lsmvs/merging/mesh_merger.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/commands/evaluation_input.h"
#include "lsmvs/cli/mesh_memory.h"
#include "lsmvs/cli/output_check.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/merging/vertex_views.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// Coordinates are shifted where single precision would lose this part of an edge.
constexpr double kMaxRoundingPart = 0.01, kFloatRounding = 6e-8;

// Where the meshes overlap all over: the 600 bytes per face of MergeMeshes, and the meshes.
constexpr MeshMemoryModel kMemory = {.all = 700, .in_memory = 100};

class MeshMergerCommand : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info;
    info.name = "mesh_merger";
    info.summary = "Overlapping meshes of different runs -> one mesh";
    info.details =
        "Joins meshes in one frame, such as two flights, a drone and a ground survey, or parts "
        "that another program made, into one oriented manifold. Where meshes overlap the finer one "
        "is kept, up to a seam that a minimum cut leads through places where they are close; the "
        "coarser one is split towards the seam, both are moved together in a band around it, and "
        "zipped. Elsewhere vertices keep their position bit for bit. Holes of one mesh that "
        "another covers are filled. The order of the inputs does not matter.\n"
        "Registration errors up to --MeshMerging.max_offset edge lengths are absorbed around the "
        "seam; larger ones are refused with what was measured: align the models first, with colmap "
        "model_aligner or model_merger.\n"
        "Colours, normals, quality and views are carried over: if INPUT.vis lies beside every "
        "input, OUTPUT.vis is written. With --workspace_path the views tell which mesh stands in "
        "space that was seen empty, which one is better seen where two contradict each other, and "
        "where a new surface through tetrahedra runs. .vis files number the photos of "
        "--workspace_path, or, for a mesh that lies in a dense workspace of its own, of that one: "
        "then they are renumbered by the photos' names. For a mesh without .vis the photos of that "
        "workspace count that have it before them; OUTPUT.vis is then written, too.";
    info.examples = {
        "lsmvs mesh_merger --input_path flight1.ply --input_path flight2.ply --output_path all.ply",
        "lsmvs mesh_merger --input_path old.ply --input_path new.ply --output_path all.ply "
        "--MeshMerging.conflict_winner newer",
        "lsmvs mesh_merger --input_path a/dense/0/meshed-refined.ply --input_path "
        "b/dense/0/meshed-refined.ply --output_path merged.ply --workspace_path project/dense/0"};
    info.required = {"input_path", "output_path"};
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &input_paths_, "A mesh to merge (PLY); give two or more.");
    options->Add("output_path", &output_path_, "The mesh to write (PLY).");
    options->Add("workspace_path", &workspace_path_,
                 "Dense workspace with the photos that the inputs' .vis files are about.");
    options->Add("overwrite", &overwrite_, "Replace the output if it is there.");
    DescribeMeshScratch(&scratch_path_, options);
    options_.Describe(options);
  }

  void Run(const CommandContext& context) override {
    CheckPaths();
    const MeshMemory memory("mesh_merger", {input_paths_.begin(), input_paths_.end()}, kMemory,
                            scratch_path_, context);
    if (!workspace_path_.empty()) scene_ = LoadSceneToEvaluate(workspace_path_, false);
    std::vector<MergingInput> inputs;
    for (const std::string& path : input_paths_) {
      inputs.push_back(ReadInput(path, context.run));
    }
    const Eigen::Vector3d offset = ShiftToOrigin(&inputs);
    context.console->Begin("Merging");
    const MergedMesh merged =
        MergeMeshes(std::move(inputs), ShiftedViews(offset), options_, context.run);
    context.console->End();
    Write(merged, offset);
  }

 private:
  void CheckPaths() const {
    if (input_paths_.size() < 2) {
      throw UsageError("--input_path: give two or more meshes, each with its own --input_path");
    }
    for (size_t i = 0; i < input_paths_.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        if (!IsSameFile(input_paths_[i], input_paths_[k])) continue;
        throw UsageError("--input_path: " + input_paths_[i] + " is given twice");
      }
    }
    RefuseToReplace({output_path_, DenseWorkspace::VisibilityPath(output_path_)}, overwrite_);
  }

  static bool IsSameFile(const fs::path& a, const fs::path& b) {
    std::error_code error;
    return a == b || fs::equivalent(a, b, error);
  }

  MergingInput ReadInput(const std::string& path, const RunContext& context) const {
    MergingInput input;
    input.name = path;
    input.mesh = ReadMeshPly(path);
    const auto time = fs::last_write_time(path).time_since_epoch();
    input.modification_time = static_cast<int64_t>(time.count());
    const fs::path vis_path = DenseWorkspace::VisibilityPath(path);
    const bool has_vis = fs::exists(vis_path);
    if (!has_vis && !scene_) return input;
    const std::optional<Scene> own = scene_ ? OwnScene(path) : std::nullopt;
    PointViews views;
    if (has_vis) {
      views = ReadVisibility(vis_path, input.mesh.vertices.size());
    } else {
      const Scene& scene = own ? *own : *scene_;
      VertexViews seen = FindVertexViews(input.mesh, ViewsOf(scene, {0, 0, 0}), context);
      views.begin = std::move(seen.view_begin);
      views.view_idxs = std::move(seen.view_idxs);
    }
    if (scene_) Renumber(vis_path, own, &views);
    input.view_begin = std::move(views.begin);
    input.view_idxs = std::move(views.view_idxs);
    return input;
  }

  // The workspace that a mesh lies in, unless that is --workspace_path.
  std::optional<Scene> OwnScene(const fs::path& mesh_path) const {
    const fs::path folder = fs::absolute(mesh_path).parent_path();
    if (!fs::is_directory(folder / "sparse")) return std::nullopt;
    if (IsSameFile(folder, FindWorkspaceToEvaluate(workspace_path_).folder)) return std::nullopt;
    return LoadSceneToEvaluate(folder, false);
  }

  // Makes indices of the views of `own`, or of scene_, those of scene_. Views that it lacks are
  // left out.
  void Renumber(const fs::path& vis_path, const std::optional<Scene>& own,
                PointViews* views) const {
    const Scene& from = own ? *own : *scene_;
    for (const uint32_t view : views->view_idxs) {
      if (view < from.views.size()) continue;
      throw InputError(
          vis_path.string(),
          fmt::format("names photo {}, but the workspace has {}", view, from.views.size()),
          "give the --workspace_path that the mesh was made in");
    }
    if (!own) return;
    std::map<std::string, uint32_t> number_of;
    for (size_t i = 0; i < scene_->views.size(); ++i) {
      number_of[scene_->views[i].name] = static_cast<uint32_t>(i);
    }
    PointViews renumbered;
    renumbered.begin = {0};
    for (size_t p = 0; p + 1 < views->begin.size(); ++p) {
      for (uint64_t k = views->begin[p]; k < views->begin[p + 1]; ++k) {
        const auto found = number_of.find(from.views[views->view_idxs[k]].name);
        if (found != number_of.end()) renumbered.view_idxs.push_back(found->second);
      }
      std::sort(renumbered.view_idxs.begin() + static_cast<std::ptrdiff_t>(renumbered.begin.back()),
                renumbered.view_idxs.end());
      renumbered.begin.push_back(renumbered.view_idxs.size());
    }
    *views = std::move(renumbered);
  }

  // Subtracts a common origin where coordinates are large, such as UTM's. It is a multiple of a
  // power of two, so that no digit is lost, and does not depend on the order of the inputs.
  static Eigen::Vector3d ShiftToOrigin(std::vector<MergingInput>* inputs) {
    Eigen::AlignedBox3d box;
    double edge = std::numeric_limits<double>::infinity();
    for (const MergingInput& input : *inputs) {
      for (const Eigen::Vector3d& x : input.mesh.vertices) box.extend(x);
      const double own = MeanEdgeLength(input.mesh);
      if (own > 0) edge = std::min(edge, own);
    }
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    if (box.isEmpty()) return offset;
    const double largest =
        std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    if (!(largest * kFloatRounding > kMaxRoundingPart * edge)) return offset;
    const double step = std::exp2(std::ceil(std::log2(std::max(box.diagonal().norm(), 1e-300))));
    offset = (box.center() / step).array().round() * step;
    for (MergingInput& input : *inputs) {
      for (Eigen::Vector3d& x : input.mesh.vertices) x -= offset;
    }
    return offset;
  }

  // A scene's views in the coordinates of meshes from which `offset` is subtracted.
  static std::vector<View> ViewsOf(const Scene& scene, const Eigen::Vector3d& offset) {
    std::vector<View> views = scene.views;
    for (View& view : views) {
      view.cam_from_world.translation +=
          view.cam_from_world.rotation * (offset - scene.world_offset);
    }
    return views;
  }
  std::vector<View> ShiftedViews(const Eigen::Vector3d& offset) const {
    return scene_ ? ViewsOf(*scene_, offset) : std::vector<View>{};
  }

  void Write(const MergedMesh& merged, const Eigen::Vector3d& offset) const {
    const fs::path vis_path = DenseWorkspace::VisibilityPath(output_path_);
    fs::remove(vis_path);  // of a mesh that was here
    WriteMeshPly(output_path_, merged.mesh, offset);
    if (!merged.view_begin.empty()) WriteVisibility(vis_path, merged.view_begin, merged.view_idxs);
    const MeshMergerCounters& counters = merged.counters;
    for (const std::string& message : merged.messages) LOG(WARNING) << message;
    fmt::print(
        "{} faces; {} at seams, {} vertices at seams changed; meshes were {:.3g} apart ({:.1f} "
        "edge "
        "lengths)\n{}\n",
        merged.mesh.faces.size(), counters.num_new_faces, counters.num_moved_vertices,
        counters.max_offset, counters.max_offset_edges, output_path_);
  }

  std::vector<std::string> input_paths_;
  std::string output_path_, workspace_path_, scratch_path_;
  bool overwrite_ = false;
  MeshMergerOptions options_;

  std::optional<Scene> scene_;
};

}  // namespace

std::unique_ptr<Command> MakeMeshMerger() { return std::make_unique<MeshMergerCommand>(); }

}  // namespace lsmvs
