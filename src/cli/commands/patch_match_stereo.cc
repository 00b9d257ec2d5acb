#include "lsmvs/workflow/single_stages.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakePatchMatchStereoCommand() {
  CommandInfo info = {
      "patch_match_stereo",
      "Photos -> depth and normal maps",
      "Estimates depth and normal maps of all photos of a dense workspace, on the CPU. Writes "
      "stereo/depth_maps/<image>.{photometric,geometric}.bin and the same under "
      "stereo/normal_maps, in COLMAP's format: "
      "`colmap stereo_fusion` reads them.\n"
      "Maps that are there are kept: a stopped run goes on at the next photo, and maps that "
      "COLMAP made are used "
      "(--overwrite replaces those).\n"
      "stereo/patch-match.cfg is honoured, as in COLMAP: pairs of lines, the name of a photo and "
      "its sources: names with commas between, best first (the first "
      "--PatchMatchStereo.max_num_neighbors of them are used); or __all__; or __auto__, N: "
      "those that this program selects, at most N. Photos that are not listed get no depth. A "
      "list of __auto__, 20 alone, as COLMAP "
      "writes it, says nothing.",
      {"lsmvs patch_match_stereo --workspace_path project/dense/0"},
      {"workspace_path"},
      "workspace_path",
      {"pmvs_option_name", "log_to_stderr", "PatchMatchStereo.gpu_index",
       "PatchMatchStereo.num_samples", "PatchMatchStereo.ncc_sigma",
       "PatchMatchStereo.incident_angle_sigma", "PatchMatchStereo.cache_size",
       "PatchMatchStereo.write_consistency_graph"}};
  return MakeOptionsCommand<PatchMatchStereoRun>(std::move(info), RunPatchMatchStereo);
}

}  // namespace lsmvs
