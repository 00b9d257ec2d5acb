#include "lsmvs/cli/command_table.h"

#include "lsmvs/cli/commands/commands.h"

namespace lsmvs {

const std::vector<CommandFactory>& CommandTable() {
  static const std::vector<CommandFactory> table = {
      MakeQuasiDenseMatcher,   MakePatchMatchStereoCommand,
      MakeStereoFusionCommand, MakeVisibilityMesherCommand,
      MakeMeshRefinerCommand,  MakeMeshTexturerCommand,
      MakeMeshSimplifier,      MakeMeshEvaluator,
      MakeMeshRenderer,        MakeMeshComparer,
      MakeMeshExporter,        MakeMeshMerger,
      MakeMapConverter,        MakeRunStatusCommand,
      MakeRunTaskCommand,
  };
  return table;
}

}  // namespace lsmvs
