#include "lsmvs/workflow/reconstruct_project.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeMesherCommand() {
  CommandInfo info = {
      "lsmvs-mesher",
      "From what `colmap mapper` leaves to a refined mesh, in one command",
      "WORKSPACE is a COLMAP project (images/ and sparse/0, sparse/1, ...), whose models are "
      "undistorted by `colmap image_undistorter` into dense/0, dense/1, ...; or a folder that "
      "automatic_reconstructor made; or a dense workspace itself. Stages of each dense workspace:\n"
      "- patch_match_stereo: depth and normal maps in stereo/ (COLMAP's format)\n"
      "- stereo_fusion: fused.ply and fused.ply.vis (COLMAP's format)\n"
      "- quasi_dense_matcher, in the place of these two with --quality low\n"
      "- visibility_mesher: meshed-visibility.ply\n"
      "- mesh_refiner: meshed-refined.ply, with vertex colours\n"
      "- mesh_texturer, with --texture: textured/mesh.ply and its pages textured/texture*.png\n"
      "A rerun skips what is up to date by lsmvs/run.json; a stopped or killed run goes on where "
      "it was. Files that COLMAP or you made are used as they are; where one is in the way, the "
      "run stops, or replaces it with --overwrite. Ctrl-C ends a run cleanly. Results do not "
      "depend on "
      "the number of threads.",
      {"lsmvs-mesher project", "lsmvs-mesher project --quality medium --texture --max_memory 8GB",
       "lsmvs-mesher project/dense/0 --from visibility_mesher --VisibilityMeshing.max_proj_dist 1"},
      {"workspace_path"},
      "workspace_path",
      {"log_to_stderr", "use_gpu", "gpu_index", "sparse", "dense", "PatchMatchStereo.gpu_index",
       "PatchMatchStereo.num_samples", "PatchMatchStereo.ncc_sigma",
       "PatchMatchStereo.incident_angle_sigma", "PatchMatchStereo.cache_size",
       "PatchMatchStereo.write_consistency_graph", "StereoFusion.max_traversal_depth",
       "StereoFusion.use_cache", "StereoFusion.cache_size"}};
  return MakeOptionsCommand<ProjectReconstructionOptions>(std::move(info), ReconstructProject);
}

}  // namespace lsmvs
