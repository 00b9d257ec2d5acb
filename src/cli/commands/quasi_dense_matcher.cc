#include "lsmvs/stereo/quasi_dense_matcher.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/scene_keypoints.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

class QuasiDenseMatcherCommand : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info;
    info.name = "quasi_dense_matcher";
    info.summary = "Photos -> point cloud with visibility, by interest points: the fast way";
    info.details =
        "Matches interest points of the photos of a dense workspace from coarse to fine, without "
        "depth maps: seconds where patch_match_stereo takes minutes. Writes --output_path in "
        "COLMAP's format (position, normal, colour) and beside it <output_path>.vis, the views "
        "that see each point, as stereo_fusion does.\n"
        "The features of --database_path join the interest points where they are those of these "
        "photos; by default the database.db of the workspace or of its project is taken if it is "
        "there.";
    info.examples = {
        "lsmvs quasi_dense_matcher --workspace_path project/dense/0 --output_path "
        "project/dense/0/fused.ply"};
    info.required = {"workspace_path", "output_path"};
    info.positional = "workspace_path";
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("workspace_path", &workspace_path_, "Dense workspace");
    options->Add("output_path", &output_path_, "Cloud to write, such as WORKSPACE/fused.ply");
    options->Add("mask_path", &mask_path_,
                 "Folder with masks: of image a/b.jpg it is a/b.jpg.png; black is not used");
    options->Add("max_image_size", &max_image_size_,
                 "Longer side in pixels to which photos are reduced; 0: full size", {0, 1000000});
    options->Add("database_path", &database_path_,
                 "COLMAP's database whose features join; empty: looked for; none: not used");
    options->Add("overwrite", &overwrite_, "Replace an --output_path that is there");
    selection_.Describe(options);
    matching_.Describe(options);
  }

  void Run(const CommandContext& context) override {
    RefuseToOverwrite();
    const DenseWorkspace workspace{workspace_path_};
    LoadSceneOptions loading;
    loading.mask_folder = mask_path_;
    const Scene scene = LoadScene(workspace, loading);
    ImageStoreOptions storing;
    storing.max_image_size = max_image_size_;
    storing.budget_bytes = context.run.memory_budget_bytes / 5;
    const auto images = MakeImageStore(scene, storing);
    const std::vector<std::vector<Eigen::Vector2f>> keypoints = Keypoints(workspace, scene);
    context.display->Begin("Matching interest points");
    const QuasiDenseResult result = MatchQuasiDense(
        scene, *images, SelectNeighbors(scene, selection_), keypoints, matching_, context.run);
    if (result.status != QuasiDenseStatus::kSuccess) {
      throw InputError(workspace_path_, result.message, Remedy(result.status));
    }
    context.display->End(result.message);
    WriteFusedCloud(output_path_, result.cloud, scene);
    fmt::print("{}\n", output_path_);
  }

 private:
  void RefuseToOverwrite() const {
    for (const auto& path :
         {std::filesystem::path(output_path_), DenseWorkspace::VisibilityPath(output_path_)}) {
      if (!overwrite_ && std::filesystem::exists(path)) {
        throw Error(
            ExitCode::kOverwrite,
            fmt::format("{}: is there already; give --overwrite 1 to replace it", path.string()));
      }
    }
  }

  std::vector<std::vector<Eigen::Vector2f>> Keypoints(const DenseWorkspace& workspace,
                                                      const Scene& scene) const {
    if (database_path_ == "none") return {};
    const std::filesystem::path database =
        database_path_.empty() ? FindDatabase(workspace) : std::filesystem::path(database_path_);
    if (database.empty()) return {};
    return ReadSceneKeypoints(database, scene);
  }

  static std::string Remedy(QuasiDenseStatus status) {
    if (status == QuasiDenseStatus::kNoDepthRange) {
      return "give --QuasiDenseMatching.depth_min and --QuasiDenseMatching.depth_max";
    }
    return "check the poses, and that the photos overlap and show texture";
  }

  std::string workspace_path_, output_path_, mask_path_, database_path_;
  int max_image_size_ = 0;
  bool overwrite_ = false;
  ViewSelectionOptions selection_;
  QuasiDenseOptions matching_;
};

}  // namespace

std::unique_ptr<Command> MakeQuasiDenseMatcher() {
  return std::make_unique<QuasiDenseMatcherCommand>();
}

}  // namespace lsmvs
