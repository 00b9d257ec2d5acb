#include "lsmvs/workflow/compare_meshes.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshComparer() {
  CommandInfo info;
  info.name = "mesh_comparer";
  info.summary = "Compare the meshes of a workspace side by side, on one page";
  info.details =
      "Measures meshed-refined.ply, meshed-visibility.ply and COLMAP's meshed-poisson.ply, "
      "meshed-delaunay.ply and meshed-advancing-front.ply, those that are there, and writes "
      "lsmvs/report/index.html (one file that opens from disk without network), report.json and "
      "pictures. --run_colmap first runs COLMAP's meshers whose result is missing; what cannot "
      "run is named in the report.\n"
      "Clouds have figures but no picture: those among --input_paths, and what PMVS-2 made in "
      "the workspace's folder pmvs/ (prepared by `colmap image_undistorter --output_type PMVS`). "
      "Results of PMVS may also be named: a .patch file, a .ply, or its folder.\n"
      "Reports are replaced; nothing else of the workspace is.";
  info.examples = {"lsmvs mesh_comparer --workspace_path dense",
                   "lsmvs mesh_comparer --workspace_path dense --run_colmap",
                   "lsmvs mesh_comparer --workspace_path dense --ground_truth_path truth.ply",
                   "lsmvs mesh_comparer --workspace_path dense --input_paths pmvs"};
  info.required = {"workspace_path"};
  info.positional = "workspace_path";
  return MakeOptionsCommand<MeshComparisonOptions>(std::move(info), CompareMeshes);
}

}  // namespace lsmvs
