#include "lsmvs/workflow/convert_maps.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMapConverter() {
  CommandInfo info = {
      "map_converter",
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
  return MakeOptionsCommand<MapConversionOptions>(std::move(info), ConvertMaps);
}

}  // namespace lsmvs
