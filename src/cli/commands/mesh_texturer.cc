#include "lsmvs/workflow/single_stages.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshTexturerCommand() {
  CommandInfo info = {
      "mesh_texturer",
      "Mesh + photos -> textured mesh",
      "Gives each face the photo that shows it best, with as few and as faint seams as a "
      "graph cut finds; balances exposure, leaves out who walked by, levels and fades what "
      "is left at seams. Texels are copied pixels: nothing is shifted, blurred or "
      "sharpened.\n"
      "Writes mesh.ply and its pages texture.png, texture_1.png, ... to the folder "
      "--output_path. The PLY is COLMAP's and MeshLab's dialect; lsmvs mesh_exporter turns "
      "it into OBJ, GLB and 3D Tiles. Any PLY mesh in the coordinates of the workspace will "
      "do, COLMAP's too; its surface stays as it is, but wide faces are split.",
      {"lsmvs mesh_texturer --workspace_path project/dense/0 --input_path "
       "project/dense/0/meshed-refined.ply --output_path project/dense/0/textured",
       "lsmvs mesh_texturer --workspace_path dense/0 --input_path dense/0/meshed-poisson.ply "
       "--output_path poisson --MeshTextureMapping.texture_scale_factor 0.5"},
      {"workspace_path", "input_path", "output_path"},
      "workspace_path",
      {"MeshTextureMapping.min_cos_normal_angle", "MeshTextureMapping.min_visible_vertices",
       "MeshTextureMapping.view_selection_smoothing_iterations",
       "MeshTextureMapping.inpaint_radius", "MeshTextureMapping.color_correction_regularization",
       "MeshTextureMapping.num_threads"}};
  return MakeOptionsCommand<MeshTexturingRun>(std::move(info), RunMeshTexturer);
}

}  // namespace lsmvs
