#include "lsmvs/cli/command_table.h"
#include "lsmvs/colmap_adapter/option_synonyms.h"
#include "lsmvs/program/run_program.h"

int main(int argc, char** argv) {
  return lsmvs::RunCommandTable(lsmvs::CommandTable(), {argv + 1, argv + argc},
                                lsmvs::ColmapSynonyms());
}
