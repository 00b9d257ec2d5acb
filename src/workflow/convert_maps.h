#pragma once

#include <string>

#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct MapConversionOptions {
  std::string workspace_path;
  MapFormat output_format = MapFormat::kCompact;
  // Folder in whose stereo/ the maps are written; empty: they are replaced.
  std::string output_path;

  void Describe(OptionSet* options);
};

// Writes all depth and normal maps of a dense workspace in the format asked for. Each is replaced
// as a whole. Throws InputError for maps that cannot be read.
void ConvertMaps(const MapConversionOptions& options, const CommandContext& context);

}  // namespace lsmvs
