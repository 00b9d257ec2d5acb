#include "lsmvs/workflow/mesh_clouds.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeVisibilityMesherCommand() {
  CommandInfo info = {
      "visibility_mesher",
      "Point cloud with visibility -> mesh",
      "Makes the surface that agrees with what each view saw, as COLMAP's delaunay_mesher "
      "does: a minimum cut of a Delaunay "
      "tetrahedralisation. Reads fused.ply and fused.ply.vis of a dense workspace (or with "
      "--input_type sparse the points "
      "of its sparse model) and writes a triangle mesh with colours and normals, and "
      "beside it OUTPUT.vis: the views of each vertex, in the format of fused.ply.vis. The "
      "photos need not be there.\n"
      "With several --input_path, workspaces or clouds whose models are in one frame (two "
      "flights, sub-models of one project), the clouds are meshed as if they were one. Their "
      "order does not matter; clouds of one model share its photos, and a photo that two models "
      "have counts twice. The record of the "
      "run goes to lsmvs/ beside OUTPUT; the run prints which numbers in OUTPUT.vis the "
      "photos of each input have.",
      {"lsmvs visibility_mesher --input_path project/dense/0 --output_path "
       "project/dense/0/meshed-visibility.ply",
       "lsmvs visibility_mesher --input_type sparse --input_path project/sparse/0 "
       "--output_path project/meshed-sparse.ply",
       "lsmvs visibility_mesher --input_path flight_1/dense/0 --input_path flight_2/dense/0 "
       "--output_path both.ply"},
      {"input_path", "output_path"},
      "input_path",
      {"log_to_stderr"}};
  return MakeOptionsCommand<CloudMeshingRun>(std::move(info), MeshClouds);
}

}  // namespace lsmvs
