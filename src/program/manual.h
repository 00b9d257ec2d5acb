#pragma once

#include <string>
#include <vector>

#include "lsmvs/program/command.h"

namespace lsmvs {

// A file of the documentation that is installed with the programs.
struct ManualFile {
  std::string path;  // relative to share/
  std::string text;
};

// The manual pages of both programs and of every command (man(7)), and the completion of their
// command lines in bash, all from the option tables: man/man1/lsmvs-mesh_refiner.1, ...,
// bash-completion/completions/lsmvs. `mesher` makes the command of lsmvs-mesher.
std::vector<ManualFile> MakeManual(const std::vector<CommandFactory>& commands,
                                   const CommandFactory& mesher);

}  // namespace lsmvs
