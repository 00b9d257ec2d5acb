#include "lsmvs/workflow/export_mesh.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshExporter() {
  CommandInfo info;
  info.name = "mesh_exporter";
  info.summary = "Mesh with texture or vertex colours -> PLY, OBJ, GLB or 3D Tiles";
  info.details =
      "PLY: the dialect of COLMAP's mesh_texturer, MeshLab and OpenMVS. OBJ: with MTL. GLB: one "
      "file with everything in it, y up. Pages of the texture are written beside the output as "
      "<name>_<number>, unless they lie there already.\n"
      "OBJ and GLB have single precision: where coordinates are large an offset is subtracted "
      "and written to <name>.offset.txt.\n"
      "3DTILES: --output_path is a folder; it gets tileset.json and tiles/*.glb, version 1.1, "
      "with levels of detail, for Cesium and 3d-tiles-renderer. z is up; with --origin the "
      "mesh's coordinates are metres east, north and up of that place, and the tileset lies "
      "there on the Earth.";
  info.examples = {
      "lsmvs mesh_exporter --input_path dense/textured/mesh.ply --output_path model.glb "
      "--output_type GLB --workspace_path dense",
      "lsmvs mesh_exporter --input_path meshed-refined.ply --output_path model.obj "
      "--output_type OBJ",
      "lsmvs mesh_exporter --input_path dense/textured/mesh.ply --output_path tiles "
      "--output_type 3DTILES --workspace_path dense"};
  info.required = {"input_path", "output_path"};
  return MakeOptionsCommand<MeshExportOptions>(std::move(info), ExportMesh);
}

}  // namespace lsmvs
