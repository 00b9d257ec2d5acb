#include "lsmvs/workflow/render_mesh.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshRenderer() {
  CommandInfo info;
  info.name = "mesh_renderer";
  info.summary = "Draw a mesh as PNG, from the pose of a photo or on a turntable";
  info.details =
      "Needs no display and no graphics card. With --workspace_path and without --view_name or "
      "--turntable the mesh is drawn from the photo that shows most sparse points; without a "
      "workspace it stands on a turntable.\n"
      "--num_frames above 1 turns the turntable: <output>-000.png and so on are written.";
  info.examples = {
      "lsmvs mesh_renderer --input_path mesh.ply --output_path mesh.png --workspace_path dense",
      "lsmvs mesh_renderer --input_path mesh.ply --output_path mesh.png --azimuth 30 --elevation "
      "25",
      "lsmvs mesh_renderer --input_path mesh.ply --output_path turn.png --num_frames 36 --style "
      "lit"};
  info.required = {"input_path", "output_path"};
  return MakeOptionsCommand<MeshPictureOptions>(std::move(info), DrawMesh);
}

}  // namespace lsmvs
