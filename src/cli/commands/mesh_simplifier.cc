#include "lsmvs/workflow/simplify_mesh_file.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshSimplifier() {
  CommandInfo info;
  info.name = "mesh_simplifier";
  info.summary = "Mesh -> mesh with fewer faces, within a distance of it";
  info.details =
      "Collapses edges in the order of their quadric error while the two surfaces stay within "
      "--MeshSimplification.max_error of each other: pixels of the photo that sees the place "
      "finest with --workspace_path (default 0.25), else the unit of the file. Borders stay "
      "within it, too; what is manifold stays manifold. With a target ratio alone nothing bounds "
      "the error.\n"
      "Vertices keep their colours; if INPUT.vis is there, OUTPUT.vis gets the views of the "
      "nearest vertex of the input. Arguments are those of COLMAP's mesh_simplifier, but for "
      "max_error, which is a distance here.";
  info.examples = {
      "lsmvs mesh_simplifier --input_path meshed-visibility.ply --output_path simple.ply "
      "--workspace_path project/dense/0",
      "lsmvs mesh_simplifier --input_path mesh.ply --output_path simple.ply "
      "--MeshSimplification.max_error 0.01 --MeshSimplification.target_face_ratio 0.1"};
  info.required = {"input_path", "output_path"};
  return MakeOptionsCommand<MeshSimplificationOptions>(std::move(info), SimplifyMeshFile);
}

}  // namespace lsmvs
