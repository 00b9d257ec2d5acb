#include "lsmvs/workflow/convert_maps.h"

#include <fmt/format.h>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/scene_loader.h"

namespace lsmvs {

void MapConversionOptions::Describe(OptionSet* options) {
  options->Add("workspace_path", &workspace_path, "Dense workspace with the maps.");
  options->AddEnum("output_format", &output_format, "Format that the maps are to have.",
                   {{"compact", MapFormat::kCompact}, {"colmap", MapFormat::kColmap}});
  options->Add("output_path", &output_path,
               "Folder in whose stereo/ the maps are written; without it they are replaced.");
}

void ConvertMaps(const MapConversionOptions& options, const CommandContext& context) {
  const DenseWorkspace from{options.workspace_path};
  const DenseWorkspace to{options.output_path.empty() ? options.workspace_path
                                                      : options.output_path};
  LoadSceneOptions load;
  load.check_images = false;
  const Scene scene = LoadScene(from, load);
  size_t num_converted = 0, num_done = 0;
  context.console->Begin("map_converter");
  for (const View& view : scene.views) {
    context.run.ThrowIfCancelled();
    for (const DepthMapKind type : {DepthMapKind::kPhotometric, DepthMapKind::kGeometric}) {
      num_converted += ConvertDepthMap(from, view, type, options.output_format, to) ? 1 : 0;
    }
    context.run.Report(static_cast<double>(++num_done) / static_cast<double>(scene.views.size()));
  }
  context.console->End(fmt::format("{} maps converted", num_converted));
}

}  // namespace lsmvs
