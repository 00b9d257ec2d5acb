#include "lsmvs/workflow/single_stages.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeStereoFusionCommand() {
  CommandInfo info = {
      "stereo_fusion",
      "Depth and normal maps -> point cloud with visibility",
      "Fuses the depth and normal maps of a dense workspace, ours or COLMAP's, into one "
      "cloud. Writes --output_path in "
      "COLMAP's format (position, normal, colour) and beside it <output_path>.vis, the views "
      "that see each point: both "
      "are needed by `lsmvs visibility_mesher` and `colmap delaunay_mesher`. Depth maps "
      "without normal maps will do: the normals are derived from the depths.",
      {"lsmvs stereo_fusion --workspace_path project/dense/0 --output_path "
       "project/dense/0/fused.ply"},
      {"workspace_path", "output_path"},
      "workspace_path",
      {"pmvs_option_name", "log_to_stderr", "StereoFusion.max_traversal_depth",
       "StereoFusion.use_cache", "StereoFusion.cache_size"}};
  return MakeOptionsCommand<StereoFusionRun>(std::move(info), RunStereoFusion);
}

}  // namespace lsmvs
