#pragma once

#include <string>

#include "lsmvs/exporting/mesh_exporter.h"
#include "lsmvs/exporting/tileset_exporter.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

enum class ExportType { kPly, kObj, kGlb, k3dTiles };

struct MeshExportOptions {
  std::string input_path;   // mesh (PLY, with or without texture)
  std::string output_path;  // file; of k3dTiles the folder
  ExportType output_type = ExportType::kGlb;
  // Workspace whose photos tell what is up and in front; empty: (0, -1, 0) is up.
  std::string workspace_path;
  // What is up, as x,y,z; empty: as above.
  std::string up;
  TextureEncoding encoding;
  bool compress = false;  // of kGlb
  // Of k3dTiles: place of the mesh's origin, as latitude,longitude,height (WGS 84, degrees and
  // metres); empty: nowhere on the Earth.
  std::string origin;
  TilesetOptions tileset;
  bool overwrite = false;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

// Writes a mesh in another format. Throws UsageError for options that do not go together,
// Error(kOverwrite) if an output is there, InputError for input that is no mesh.
void ExportMesh(const MeshExportOptions& options, const CommandContext& context);

}  // namespace lsmvs
