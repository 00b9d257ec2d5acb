#include "lsmvs/workflow/merge_mesh_files.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshMerger() {
  CommandInfo info;
  info.name = "mesh_merger";
  info.summary = "Overlapping meshes of different runs -> one mesh";
  info.details =
      "Joins meshes in one frame, such as two flights, a drone and a ground survey, or parts "
      "that another program made, into one oriented manifold. Where meshes overlap the finer one "
      "is kept, up to a seam that a minimum cut leads through places where they are close; the "
      "coarser one is split towards the seam, both are moved together in a band around it, and "
      "zipped. Elsewhere vertices keep their position bit for bit. Holes of one mesh that "
      "another covers are filled. The order of the inputs does not matter.\n"
      "Registration errors up to --MeshMerging.max_offset edge lengths are absorbed around the "
      "seam; larger ones are refused with what was measured: align the models first, with colmap "
      "model_aligner or model_merger.\n"
      "Colours, normals, quality and views are carried over: if INPUT.vis lies beside every "
      "input, OUTPUT.vis is written. With --workspace_path the views tell which mesh stands in "
      "space that was seen empty, which one is better seen where two contradict each other, and "
      "where a new surface through tetrahedra runs. .vis files number the photos of "
      "--workspace_path, or, for a mesh that lies in a dense workspace of its own, of that one: "
      "then they are renumbered by the photos' names. For a mesh without .vis the photos of that "
      "workspace count that have it before them; OUTPUT.vis is then written, too.";
  info.examples = {
      "lsmvs mesh_merger --input_path flight1.ply --input_path flight2.ply --output_path all.ply",
      "lsmvs mesh_merger --input_path old.ply --input_path new.ply --output_path all.ply "
      "--MeshMerging.conflict_winner newer",
      "lsmvs mesh_merger --input_path a/dense/0/meshed-refined.ply --input_path "
      "b/dense/0/meshed-refined.ply --output_path merged.ply --workspace_path project/dense/0"};
  info.required = {"input_path", "output_path"};
  return MakeOptionsCommand<MeshMergingOptions>(std::move(info), MergeMeshFiles);
}

}  // namespace lsmvs
