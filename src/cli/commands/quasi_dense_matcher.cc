#include "lsmvs/workflow/single_stages.h"

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/options_command.h"

namespace lsmvs {

std::unique_ptr<Command> MakeQuasiDenseMatcher() {
  CommandInfo info = {
      "quasi_dense_matcher",
      "Photos -> point cloud with visibility, by interest points: the fast way",
      "Matches interest points of the photos of a dense workspace from coarse to fine, "
      "without depth maps, in about a quarter of the time of patch_match_stereo. Writes "
      "--output_path in COLMAP's format (position, normal, colour) and beside it "
      "<output_path>.vis, the views that see each point, as stereo_fusion does.",
      {"lsmvs quasi_dense_matcher --workspace_path project/dense/0 --output_path "
       "project/dense/0/fused.ply"},
      {"workspace_path", "output_path"},
      "workspace_path"};
  return MakeOptionsCommand<QuasiDenseRun>(std::move(info), RunQuasiDenseMatcher);
}

}  // namespace lsmvs
