#include "lsmvs/workflow/evaluate_mesh.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMeshEvaluator() {
  CommandInfo info;
  info.name = "mesh_evaluator";
  info.summary = "Score a mesh or a cloud against ground truth, or against the photos";
  info.details =
      "With --ground_truth_path: accuracy (share of the reconstruction near the truth), "
      "completeness (share of the truth near the reconstruction) and F1 at the thresholds, on "
      "points "
      "uniform over the area, and with --workspace_path only where at least two photos see the "
      "surface; then also the histogram of depth errors in every photo.\n"
      "Without ground truth, or with --photometric: every photo is compared with its neighbours "
      "warped through the mesh. Give --view_names with photos that the reconstruction has not "
      "seen "
      "for an honest score.\n"
      "With --texture: the mesh is drawn with its texture (or vertex colours) from the photos' "
      "poses and compared with the photos, after fitting a gain and a bias per photo: PSNR, "
      "SSIM, 1 - NCC. Of a texture also its seams and how well its pages are used. Compare "
      "textures on the same mesh, on photos that they were not made from: --view_names or "
      "--view_step.\n"
      "With --workspace_path also how complete the mesh looks from the photos' poses: holes, torn "
      "places, ragged outlines, small loose pieces.\n"
      "A file without faces is taken as a cloud; of clouds the number of points and the share of "
      "the photos that they cover are measured, too. Results of PMVS-2 are taken as it writes "
      "them: a .patch file (with its photos and scores), a .ply, or the folder pmvs/ that "
      "`colmap image_undistorter --output_type PMVS` prepared, whose cameras and photos then "
      "serve in "
      "place of a workspace. Nothing of the workspace is changed.";
  info.examples = {
      "lsmvs mesh_evaluator --input_path mesh.ply --ground_truth_path truth.ply --workspace_path "
      "dense",
      "lsmvs mesh_evaluator --input_path mesh.ply --workspace_path dense --json_path score.json",
      "lsmvs mesh_evaluator --input_path textured/mesh.ply --workspace_path dense --texture "
      "--view_step 8",
      "lsmvs mesh_evaluator --input_path pmvs --ground_truth_path truth.ply"};
  info.required = {"input_path"};
  return MakeOptionsCommand<MeshEvaluationOptions>(std::move(info), EvaluateMesh);
}

}  // namespace lsmvs
