#include <memory>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"

namespace lsmvs {

namespace {

class PatchMatchStereoCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {
        "patch_match_stereo",
        "Photos -> depth and normal maps",
        "Estimates depth and normal maps of all photos of a dense workspace, on the CPU. Writes "
        "stereo/depth_maps/<image>.{photometric,geometric}.bin and the same under "
        "stereo/normal_maps, in COLMAP's format: "
        "`colmap stereo_fusion` reads them.\n"
        "Maps that are there are kept: a stopped run goes on at the next photo, and maps that "
        "COLMAP made are used "
        "(--overwrite replaces those).",
        {"lsmvs patch_match_stereo --workspace_path project/dense/0"},
        {"workspace_path"},
        "workspace_path"};
  }

  void Describe(OptionSet* options) override {
    stage_.DescribeWorkspace(options);
    stage_.DescribeMaskPath(options);
    stage_.DescribeOverwrite(options);
    stage_.DescribePhotometricMaps(true, options);
    stage_.DescribeMaxImageSize("PatchMatchStereo.max_image_size", options);
    options_.patch_match.Describe(options);
    options_.view_selection.Describe(options);
  }

  void Run(const CommandContext& context) override {
    stage_.Apply(&options_);
    const auto reconstruction = OpenReconstruction(stage_.Workspace(), stage_, options_, context);
    RunPlanned(stage_.Workspace(), *reconstruction, MakeStereoTasks(reconstruction), stage_,
               context);
  }

 private:
  StageOptions stage_;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakePatchMatchStereoCommand() {
  return std::make_unique<PatchMatchStereoCommand>();
}

}  // namespace lsmvs
