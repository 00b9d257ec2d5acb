#include <memory>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"

namespace lsmvs {

namespace {

// COLMAP's --output_type. We write the one that the meshers read.
enum class CloudFormat { kPly };

class StereoFusionCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {"stereo_fusion",
            "Depth and normal maps -> point cloud with visibility",
            "Fuses the depth and normal maps of a dense workspace, ours or COLMAP's, into one "
            "cloud. Writes --output_path in "
            "COLMAP's format (position, normal, colour) and beside it <output_path>.vis, the views "
            "that see each point: both "
            "are needed by `lsmvs visibility_mesher` and `colmap delaunay_mesher`. Depth maps "
            "without normal maps will do: the normals are derived from the depths.",
            {"lsmvs stereo_fusion --workspace_path project/dense/0 --output_path "
             "project/dense/0/fused.ply"},
            {"workspace_path", "output_path"},
            "workspace_path",
            {"pmvs_option_name", "log_to_stderr", "StereoFusion.max_traversal_depth",
             "StereoFusion.use_cache", "StereoFusion.cache_size"}};
  }

  void Describe(OptionSet* options) override {
    stage_.DescribeWorkspace(options);
    options->AddEnum(
        "input_type", &input_type_, "Which of the depth maps to fuse.",
        {{"geometric", DepthMapKind::kGeometric}, {"photometric", DepthMapKind::kPhotometric}});
    options->Add("output_path", &output_path_, "The cloud to write, such as WORKSPACE/fused.ply.");
    options->AddEnum("output_type", &output_type_, "Format of the cloud.",
                     {{"PLY", CloudFormat::kPly}});
    stage_.DescribeBoundingBox(options);
    stage_.DescribeBoxPath(options);
    stage_.DescribeAlphaMask(options);
    stage_.DescribeSkipMissingImages(options);
    stage_.DescribeRun(options);
    options->Add(
        "StereoFusion.mask_path", &stage_.mask_path,
        "Folder with masks: of image a/b.jpg it is a/b.jpg.png; black pixels are not used.");
    stage_.DescribeMaxImageSize("StereoFusion.max_image_size", options);
    options_.fusion.Describe(options);
    options_.view_selection.Describe(options);
  }

  void Run(const CommandContext& context) override {
    stage_.Apply(&options_);
    const DenseWorkspace workspace = stage_.Workspace();
    const auto reconstruction = OpenReconstruction(workspace, stage_, options_, context);
    Task task = MakeFusionTask(reconstruction, input_type_, MapsToFuse::kPresent, output_path_);
    task.foreign_outputs = ForeignOutputs::kRefuse;
    RenameForOutput(workspace.FusedPath(), &task);
    RunPlanned(workspace, *reconstruction, {task}, stage_, context);
  }

 private:
  StageOptions stage_;
  DepthMapKind input_type_ = DepthMapKind::kGeometric;
  std::string output_path_;
  CloudFormat output_type_ = CloudFormat::kPly;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeStereoFusionCommand() {
  return std::make_unique<StereoFusionCommand>();
}

}  // namespace lsmvs
