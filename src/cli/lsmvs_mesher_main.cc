#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/colmap_adapter/option_synonyms.h"
#include "lsmvs/program/run_program.h"

int main(int argc, char** argv) {
  const std::unique_ptr<lsmvs::Command> command = lsmvs::MakeMesherCommand();
  return lsmvs::RunCommand("lsmvs-mesher", command.get(), {argv + 1, argv + argc},
                           lsmvs::ColmapSynonyms());
}
