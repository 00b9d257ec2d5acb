#include "lsmvs/cli/colmap_workspace.h"

#include <glog/logging.h>

#include <algorithm>
#include <string>

#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/scene_keypoints.h"
#include "lsmvs/colmap_adapter/stereo_config.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

MapType TypeOf(DepthMapKind kind) {
  return kind == DepthMapKind::kPhotometric ? MapType::kPhotometric : MapType::kGeometric;
}

// The folder in which `path` has the relative name `relative`.
fs::path FolderOf(const fs::path& path, const fs::path& relative) {
  fs::path folder = path;
  for ([[maybe_unused]] const fs::path& part : relative) folder = folder.parent_path();
  return folder;
}

class ColmapWorkspaceFiles : public WorkspaceFiles {
 public:
  ColmapWorkspaceFiles(const DenseWorkspace& workspace, const fs::path& database,
                       const fs::path& sources)
      : workspace_(workspace),
        database_(database),
        sources_(sources.empty() ? workspace.PatchMatchConfigPath() : sources),
        must_have_sources_(!sources.empty()) {}

  std::vector<fs::path> ModelFiles() const override {
    const fs::path folder = workspace_.SparseFolder();
    std::vector<fs::path> files;
    for (const char* name : {"cameras", "images", "points3D", "rigs", "frames"}) {
      const fs::path path = WithFormat(folder / name);
      if (fs::exists(path)) files.push_back(path);
    }
    return files;
  }

  fs::path PointsFile() const override {
    return WithFormat(workspace_.SparseFolder() / "points3D");
  }

  std::vector<SourceRule> ReadSourceRules(const Scene& scene) const override {
    if (!must_have_sources_ && !fs::exists(sources_)) return {};
    const std::vector<PatchMatchProblem> problems = ReadPatchMatchConfig(sources_);
    if (AreColmapsDefault(problems)) return {};
    return ToSourceRules(problems, scene, sources_);
  }
  fs::path SourceRulesFile() const override { return sources_; }

  std::array<fs::path, 2> DepthMapFiles(const View& view, DepthMapKind kind) const override {
    return {workspace_.DepthMapPath(view.name, TypeOf(kind)),
            workspace_.NormalMapPath(view.name, TypeOf(kind))};
  }

  void CheckDepthMap(const View& view, DepthMapKind kind) const override {
    const bool there = fs::exists(workspace_.DepthMapPath(view.name, TypeOf(kind)));
    if (there && !HasDepthMap(workspace_, view, TypeOf(kind))) {
      ReadDepthMap(workspace_, view, TypeOf(kind));  // says what is wrong
    }
  }

  void WriteDepthMap(const View& view, DepthMapKind kind, const DepthMap& map,
                     const std::vector<fs::path>& outputs) const override {
    const fs::path relative =
        workspace_.DepthMapPath(view.name, TypeOf(kind)).lexically_relative(workspace_.folder);
    const DenseWorkspace staged{FolderOf(outputs.at(0), relative)};
    lsmvs::WriteDepthMap(staged, view, TypeOf(kind), map);
  }

  std::unique_ptr<DepthMapSource> OpenDepthMaps(const Scene& scene, DepthMapKind kind,
                                                size_t budget_bytes) const override {
    return MakeDepthMapSource(workspace_, scene, TypeOf(kind), budget_bytes);
  }

  fs::path CloudFile() const override { return workspace_.FusedPath(); }

  std::vector<fs::path> CloudFiles(const fs::path& cloud) const override {
    return {cloud, DenseWorkspace::VisibilityPath(cloud)};
  }

  VisibilityCloud ReadCloud(const fs::path& cloud, const Scene& scene) const override {
    FusedCloud fused = ReadFusedCloud(cloud, scene, workspace_);
    if (!fused.message.empty()) LOG(WARNING) << fused.message;
    return std::move(fused.cloud);
  }

  void WriteCloud(const Scene& scene, const std::vector<fs::path>& outputs,
                  const std::function<void(const CloudSink&)>& write) const override {
    FusedCloudWriter writer(outputs.at(0), scene);
    write([&](const VisibilityCloud& part) { writer.Add(part); });
    writer.Commit();
  }

  fs::path KeypointFile() const override { return database_; }

  std::vector<std::vector<Eigen::Vector2f>> ReadKeypoints(const Scene& scene) const override {
    if (database_.empty()) return {};
    return ReadSceneKeypoints(database_, scene);
  }

  std::vector<fs::path> VisibleMeshFiles(const fs::path& mesh) const override {
    return {mesh, DenseWorkspace::VisibilityPath(mesh)};
  }

  void WriteVisibility(const std::vector<uint64_t>& begin, const std::vector<uint32_t>& view_idxs,
                       const fs::path& output) const override {
    lsmvs::WriteVisibility(output, begin, view_idxs);
  }

  fs::path VisibilityMeshFile() const override { return workspace_.VisibilityMeshPath(); }
  fs::path RefinedMeshFile() const override { return workspace_.RefinedMeshPath(); }
  fs::path TexturedMeshFile() const override { return workspace_.TexturedMeshPath(); }

 private:
  // Binary is preferred, as when reading.
  fs::path WithFormat(const fs::path& stem) const {
    const bool binary = fs::exists(workspace_.SparseFolder() / "cameras.bin");
    return stem.string() + (binary ? ".bin" : ".txt");
  }

  DenseWorkspace workspace_;
  fs::path database_, sources_;
  bool must_have_sources_;
};

}  // namespace

std::shared_ptr<const WorkspaceFiles> MakeColmapWorkspaceFiles(const DenseWorkspace& workspace,
                                                               const fs::path& database,
                                                               const fs::path& sources) {
  return std::make_shared<ColmapWorkspaceFiles>(workspace, database, sources);
}

}  // namespace lsmvs
