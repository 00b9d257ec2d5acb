#include "lsmvs/colmap_adapter/workspace_files.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <span>
#include <string>

#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/scene_keypoints.h"
#include "lsmvs/colmap_adapter/stereo_config.h"
#include "lsmvs/scene/cloud_overlap.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

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

  std::vector<fs::path> ModelFiles() const override { return workspace_.ModelFiles(); }

  fs::path PointsFile() const override { return workspace_.ModelFile("points3D"); }

  std::vector<SourceRule> ReadSourceRules(const Scene& scene) const override {
    if (!must_have_sources_ && !fs::exists(sources_)) return {};
    const std::vector<PatchMatchProblem> problems = ReadPatchMatchConfig(sources_);
    if (AreColmapsDefault(problems)) return {};
    return ToSourceRules(problems, scene, sources_);
  }
  fs::path SourceRulesFile() const override { return sources_; }

  std::array<fs::path, 2> DepthMapFiles(const View& view, DepthMapKind kind) const override {
    return {workspace_.DepthMapPath(view.name, kind), workspace_.NormalMapPath(view.name, kind)};
  }

  void CheckDepthMap(const View& view, DepthMapKind kind) const override {
    const bool there = fs::exists(workspace_.DepthMapPath(view.name, kind));
    if (there && !HasDepthMap(workspace_, view, kind)) {
      ReadDepthMap(workspace_, view, kind);  // says what is wrong
    }
  }

  void WriteDepthMap(const View& view, DepthMapKind kind, const DepthMap& map,
                     MapPrecision precision, const std::vector<fs::path>& outputs) const override {
    const fs::path relative =
        workspace_.DepthMapPath(view.name, kind).lexically_relative(workspace_.folder);
    const DenseWorkspace staged{FolderOf(outputs.at(0), relative)};
    const MapFormat format =
        precision == MapPrecision::kExact ? MapFormat::kColmap : MapFormat::kCompact;
    lsmvs::WriteDepthMap(staged, view, kind, map, format);
  }

  std::unique_ptr<DepthMapSource> OpenDepthMaps(const Scene& scene, DepthMapKind kind,
                                                size_t budget_bytes) const override {
    return MakeDepthMapSource(workspace_, scene, kind, budget_bytes);
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

  void SampleCloud(const fs::path& cloud, const Scene& scene,
                   CloudSampler* sampler) const override {
    AddSample(cloud, scene, 0, sampler);
  }

  void WriteCloud(const Scene& scene, const std::vector<fs::path>& outputs,
                  const std::function<void(const CloudSink&)>& write) const override {
    FusedCloudWriter writer(outputs.at(0), scene);
    write([&](const VisibilityCloud& part) { writer.Add(part); });
    writer.Commit();
  }

  fs::path CloudPartFile(const fs::path& cloud, int part) const override {
    const fs::path absolute = fs::absolute(cloud).lexically_normal();
    std::string name = cloud.stem().string();
    // Clouds elsewhere may have the same name.
    if (absolute != fs::absolute(workspace_.FusedPath()).lexically_normal()) {
      name += "-" + Hasher().Update(absolute.string()).HexDigest().substr(0, 16);
    }
    return workspace_.RunFolder() / fmt::format("{}-part-{}.ply", name, part);
  }

  CloudCounts JoinClouds(const Scene& scene, const std::vector<fs::path>& parts,
                         const std::vector<fs::path>& outputs) const override {
    FusedCloudWriter writer(outputs.at(0), scene);
    for (const fs::path& part : parts) writer.AddFile(part);
    writer.Commit();
    return {writer.size().num_points, writer.size().num_view_entries};
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

 protected:
  // Views are numbered from `first_view` on.
  static void AddSample(const fs::path& cloud, const Scene& scene, uint32_t first_view,
                        CloudSampler* sampler) {
    std::vector<uint32_t> moved;
    VisitFusedCloud(cloud, scene.world_offset,
                    [&](const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                        std::span<const uint32_t> views) {
                      moved.assign(views.begin(), views.end());
                      for (uint32_t& view_idx : moved) view_idx += first_view;
                      sampler->Add(position, normal, moved);
                    });
  }

 private:
  DenseWorkspace workspace_;
  fs::path database_, sources_;
  bool must_have_sources_;
};

// See MakeJoinedWorkspaceFiles.
class JoinedWorkspaceFiles : public ColmapWorkspaceFiles {
 public:
  JoinedWorkspaceFiles(const DenseWorkspace& output, std::vector<CloudInput> inputs,
                       std::vector<Scene> parts)
      : ColmapWorkspaceFiles(output, {}, {}), inputs_(std::move(inputs)), parts_(std::move(parts)) {
    uint32_t num_views = 0;
    for (const Scene& part : parts_) {
      first_views_.push_back(num_views);
      num_views += static_cast<uint32_t>(part.views.size());
    }
    LSMVS_CHECK_EQ(WorkspacesOfModels(inputs_).size(), parts_.size());
  }

  std::vector<fs::path> ModelFiles() const override {
    std::vector<fs::path> files;
    for (const DenseWorkspace& workspace : WorkspacesOfModels(inputs_)) {
      const std::vector<fs::path> own = workspace.ModelFiles();
      files.insert(files.end(), own.begin(), own.end());
    }
    return files;
  }
  fs::path PointsFile() const override { return inputs_.front().workspace.ModelFile("points3D"); }
  std::vector<SourceRule> ReadSourceRules(const Scene& /*scene*/) const override { return {}; }

  std::vector<fs::path> CloudFiles(const fs::path& /*cloud*/) const override {
    std::vector<fs::path> files;
    for (const CloudInput& input : inputs_) {
      const std::vector<fs::path> own = ColmapWorkspaceFiles::CloudFiles(input.cloud);
      files.insert(files.end(), own.begin(), own.end());
    }
    return files;
  }

  // Point by point into one array, made at once: beside it nothing is held.
  VisibilityCloud ReadCloud(const fs::path& /*cloud*/, const Scene& scene) const override {
    VisibilityCloud joined;
    Reserve(&joined);
    std::vector<std::string> names;
    std::vector<std::vector<Eigen::Vector3f>> samples;
    for (const CloudInput& input : inputs_) {
      const size_t first_point = joined.size();
      const AppendedCloud appended =
          AppendFusedCloud(input.cloud, parts_[input.model_idx], input.workspace,
                           first_views_[input.model_idx], &joined);
      names.push_back(input.cloud.string());
      if (!appended.message.empty()) LOG(WARNING) << names.back() << ": " << appended.message;
      samples.push_back(SamplePositions(std::span(joined.positions).subspan(first_point)));
    }
    LSMVS_CHECK_EQ(first_views_.back() + parts_.back().views.size(), scene.views.size());
    const std::string warning = NoOverlapWarning(names, samples);
    if (!warning.empty()) LOG(WARNING) << warning;
    return joined;
  }

  void SampleCloud(const fs::path& /*cloud*/, const Scene& /*scene*/,
                   CloudSampler* sampler) const override {
    for (const CloudInput& input : inputs_) {
      AddSample(input.cloud, parts_[input.model_idx], first_views_[input.model_idx], sampler);
    }
  }

 private:
  void Reserve(VisibilityCloud* cloud) const {
    size_t num_points = 0, num_view_entries = 0;
    for (const CloudInput& input : inputs_) {
      const FusedCloudSize size = ReadFusedCloudSize(input.cloud);
      num_points += size.num_points;
      num_view_entries += size.num_view_entries;
    }
    cloud->Reserve(num_points, num_view_entries);
  }

  std::vector<CloudInput> inputs_;
  std::vector<Scene> parts_;
  std::vector<uint32_t> first_views_;  // by part
};

}  // namespace

std::vector<DenseWorkspace> WorkspacesOfModels(const std::vector<CloudInput>& inputs) {
  std::vector<DenseWorkspace> workspaces;
  for (const CloudInput& input : inputs) {
    if (input.model_idx == workspaces.size()) workspaces.push_back(input.workspace);
  }
  return workspaces;
}

std::shared_ptr<const WorkspaceFiles> MakeJoinedWorkspaceFiles(const DenseWorkspace& output,
                                                               std::vector<CloudInput> inputs,
                                                               std::vector<Scene> parts) {
  return std::make_shared<JoinedWorkspaceFiles>(output, std::move(inputs), std::move(parts));
}

std::shared_ptr<const WorkspaceFiles> MakeColmapWorkspaceFiles(const DenseWorkspace& workspace,
                                                               const fs::path& database,
                                                               const fs::path& sources) {
  return std::make_shared<ColmapWorkspaceFiles>(workspace, database, sources);
}

}  // namespace lsmvs
