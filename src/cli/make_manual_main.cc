// Writes manual pages and shell completion into the folder given: for the installation.
#include <cstdio>
#include <filesystem>

#include "lsmvs/cli/command_table.h"
#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/program/manual.h"
#include "lsmvs/util/atomic_file.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  for (const lsmvs::ManualFile& file :
       lsmvs::MakeManual(lsmvs::CommandTable(), lsmvs::MakeMesherCommand)) {
    std::filesystem::create_directories((folder / file.path).parent_path());
    lsmvs::WriteFileAtomically(folder / file.path, file.text);
  }
  return 0;
}
