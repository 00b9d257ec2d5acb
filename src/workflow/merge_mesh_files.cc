#include "lsmvs/workflow/merge_mesh_files.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "lsmvs/merging/common_origin.h"
#include "lsmvs/merging/vertex_views.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/util/error.h"
#include "lsmvs/workflow/files/mesh_memory.h"
#include "lsmvs/workflow/files/mesh_with_views.h"
#include "lsmvs/workflow/files/output_check.h"
#include "lsmvs/workflow/files/scene_input.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// Where the meshes overlap all over: the 600 bytes per face of MergeMeshes, and the meshes.
constexpr MeshMemoryModel kMemory = {.all = 700, .in_memory = 100};

bool IsSameFile(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return a == b || fs::equivalent(a, b, error);
}

void CheckPaths(const MeshMergingOptions& options) {
  const std::vector<std::string>& inputs = options.input_paths;
  if (inputs.size() < 2) {
    throw UsageError("--input_path: give two or more meshes, each with its own --input_path");
  }
  for (size_t i = 0; i < inputs.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (!IsSameFile(inputs[i], inputs[k])) continue;
      throw UsageError("--input_path: " + inputs[i] + " is given twice");
    }
  }
  RefuseToReplace(MeshWithViewsFiles(options.output_path), options.overwrite);
}

// A scene's views in the coordinates of meshes from which `offset` is subtracted.
std::vector<View> ViewsOf(const Scene& scene, const Eigen::Vector3d& offset) {
  std::vector<View> views = scene.views;
  for (View& view : views) {
    view.cam_from_world.translation += view.cam_from_world.rotation * (offset - scene.world_offset);
  }
  return views;
}

void CheckNumbers(const fs::path& mesh_path, const PointViews& views, size_t num_photos) {
  for (const uint32_t view : views.view_idxs) {
    if (view < num_photos) continue;
    throw InputError(MeshWithViewsFiles(mesh_path).back().string(),
                     fmt::format("names photo {}, but the workspace has {}", view, num_photos),
                     "give the --workspace_path that the mesh was made in");
  }
}

// Makes indices of the views of `from` those of `to`, by name. Views that `to` lacks are left out.
PointViews Renumber(const PointViews& views, const Scene& from, const Scene& to) {
  std::map<std::string, uint32_t> number_of;
  for (size_t i = 0; i < to.views.size(); ++i) {
    number_of[to.views[i].name] = static_cast<uint32_t>(i);
  }
  PointViews renumbered;
  renumbered.begin = {0};
  for (size_t p = 0; p + 1 < views.begin.size(); ++p) {
    for (uint64_t k = views.begin[p]; k < views.begin[p + 1]; ++k) {
      const auto found = number_of.find(from.views[views.view_idxs[k]].name);
      if (found != number_of.end()) renumbered.view_idxs.push_back(found->second);
    }
    std::sort(renumbered.view_idxs.begin() + static_cast<std::ptrdiff_t>(renumbered.begin.back()),
              renumbered.view_idxs.end());
    renumbered.begin.push_back(renumbered.view_idxs.size());
  }
  return renumbered;
}

// Reads the meshes with what sees their vertices.
class InputReader {
 public:
  // `workspace_path` and `scene`: of the result, empty if there is none.
  InputReader(const std::string& workspace_path, const std::optional<Scene>& scene,
              const RunContext& context)
      : workspace_path_(workspace_path), scene_(scene), context_(context) {}

  MergingInput Read(const std::string& path) const {
    MergingInput input;
    input.name = path;
    input.mesh = ReadMeshPly(path);
    const auto time = fs::last_write_time(path).time_since_epoch();
    input.modification_time = static_cast<int64_t>(time.count());
    std::optional<PointViews> views = Views(path, input.mesh);
    if (!views) return input;
    input.view_begin = std::move(views->begin);
    input.view_idxs = std::move(views->view_idxs);
    return input;
  }

 private:
  std::optional<PointViews> Views(const std::string& path, const TriangleMesh& mesh) const {
    std::optional<PointViews> views = ReadViewsOf(path, mesh.vertices.size());
    if (!scene_) return views;
    const std::optional<Scene> own = OwnScene(path);
    const Scene& scene = own ? *own : *scene_;
    if (!views) {
      VertexViews seen = FindVertexViews(mesh, ViewsOf(scene, {0, 0, 0}), context_);
      views = PointViews{std::move(seen.view_begin), std::move(seen.view_idxs)};
    }
    CheckNumbers(path, *views, scene.views.size());
    return own ? Renumber(*views, *own, *scene_) : views;
  }

  // The workspace that a mesh lies in, unless that is the result's.
  std::optional<Scene> OwnScene(const fs::path& mesh_path) const {
    const fs::path folder = fs::absolute(mesh_path).parent_path();
    if (!fs::is_directory(folder / "sparse")) return std::nullopt;
    if (IsSameFile(folder, FindWorkspaceToEvaluate(workspace_path_).folder)) return std::nullopt;
    return LoadSceneToEvaluate(folder, false);
  }

  const std::string& workspace_path_;
  const std::optional<Scene>& scene_;
  const RunContext& context_;
};

void Write(const MergedMesh& merged, const Eigen::Vector3d& offset, const std::string& output_path,
           Console* console) {
  std::optional<PointViews> views;
  if (!merged.view_begin.empty()) views = PointViews{merged.view_begin, merged.view_idxs};
  WriteMeshWithViews(output_path, merged.mesh, offset, views);
  for (const std::string& message : merged.messages) LOG(WARNING) << message;
  const MeshMergerCounters& counters = merged.counters;
  console->Print(fmt::format(
      "{} faces; {} at seams, {} vertices at seams changed; meshes were {:.3g} apart ({:.1f} edge "
      "lengths)\n{}\n",
      merged.mesh.faces.size(), counters.num_new_faces, counters.num_moved_vertices,
      counters.max_offset, counters.max_offset_edges, output_path));
}

}  // namespace

void MeshMergingOptions::Describe(OptionSet* options) {
  options->Add("input_path", &input_paths, "A mesh to merge (PLY); give two or more.");
  options->Add("output_path", &output_path, "The mesh to write (PLY).");
  options->Add("workspace_path", &workspace_path,
               "Dense workspace with the photos that the inputs' .vis files are about.");
  options->Add("overwrite", &overwrite, "Replace the output if it is there.");
  DescribeMeshScratch(&scratch_path, options);
  merging.Describe(options);
}

void MergeMeshFiles(const MeshMergingOptions& options, const CommandContext& context) {
  CheckPaths(options);
  const std::vector<std::string>& paths = options.input_paths;
  const MeshMemory memory("mesh_merger", {paths.begin(), paths.end()}, kMemory,
                          options.scratch_path, context);
  const std::optional<Scene> scene = LoadSceneIfGiven(options.workspace_path, false);
  const InputReader reader(options.workspace_path, scene, context.run);
  std::vector<MergingInput> inputs;
  for (const std::string& path : paths) inputs.push_back(reader.Read(path));
  const Eigen::Vector3d offset = ShiftToCommonOrigin(&inputs);
  const std::vector<View> views = scene ? ViewsOf(*scene, offset) : std::vector<View>();
  context.console->Begin("Merging");
  const MergedMesh merged = MergeMeshes(std::move(inputs), views, options.merging, context.run);
  context.console->End();
  Write(merged, offset, options.output_path, context.console);
}

}  // namespace lsmvs
