#include <fmt/format.h>

#include <memory>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

class MapConverterCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {"map_converter",
            "Depth and normal maps from COLMAP's format to the compact one, and back",
            "Converts all maps in stereo/ of a dense workspace: compact ones take 1.2 to 2 bytes "
            "per pixel instead of 16, and keep the depth within a 40th of a pixel's size and the "
            "normal within a third of a degree. All commands of this program read either format; "
            "COLMAP reads its own only. "
            "Files keep their names. Maps that were converted count as yours: a run uses them as "
            "they are.",
            {"lsmvs map_converter project/dense/0 --output_format compact",
             "lsmvs map_converter project/dense/0 --output_format colmap --output_path for_colmap"},
            {"workspace_path"},
            "workspace_path"};
  }

  void Describe(OptionSet* options) override {
    options->Add("workspace_path", &workspace_path_, "Dense workspace with the maps.");
    options->AddEnum("output_format", &format_, "Format that the maps are to have.",
                     {{"compact", MapFormat::kCompact}, {"colmap", MapFormat::kColmap}});
    options->Add("output_path", &output_path_,
                 "Folder in whose stereo/ the maps are written; without it they are replaced.");
  }

  void Run(const CommandContext& context) override {
    const DenseWorkspace from{workspace_path_};
    const DenseWorkspace to{output_path_.empty() ? workspace_path_ : output_path_};
    LoadSceneOptions load;
    load.check_images = false;
    const Scene scene = LoadScene(from, load);
    size_t num_converted = 0, num_done = 0;
    context.display->Begin("map_converter");
    for (const View& view : scene.views) {
      context.run.ThrowIfCancelled();
      for (const DepthMapKind type : {DepthMapKind::kPhotometric, DepthMapKind::kGeometric}) {
        num_converted += ConvertDepthMap(from, view, type, format_, to) ? 1 : 0;
      }
      context.run.Report(static_cast<double>(++num_done) / static_cast<double>(scene.views.size()));
    }
    context.display->End(fmt::format("{} maps converted", num_converted));
  }

 private:
  std::string workspace_path_, output_path_;
  MapFormat format_ = MapFormat::kCompact;
};

}  // namespace

std::unique_ptr<Command> MakeMapConverter() { return std::make_unique<MapConverterCommand>(); }

}  // namespace lsmvs
