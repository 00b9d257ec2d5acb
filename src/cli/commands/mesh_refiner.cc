#include "lsmvs/workflow/single_stages.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshRefinerCommand() {
  CommandInfo info = {
      "mesh_refiner",
      "Mesh + photos -> refined mesh",
      "Moves the vertices of a mesh until the photos agree through it, and adapts the size "
      "of its triangles to what the photos "
      "resolve. Regions that would get worse keep their input; at the end faces that are not "
      "needed are saved. Any PLY mesh in the "
      "coordinates of the workspace will do, "
      "COLMAP's too. Writes a triangle mesh with vertex colours.",
      {"lsmvs mesh_refiner --workspace_path project/dense/0 --input_path "
       "project/dense/0/meshed-visibility.ply "
       "--output_path project/dense/0/meshed-refined.ply"},
      {"workspace_path", "input_path", "output_path"},
      "workspace_path"};
  return MakeOptionsCommand<MeshRefinementRun>(std::move(info), RunMeshRefiner);
}

}  // namespace lsmvs
