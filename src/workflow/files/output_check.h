#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lsmvs {

// Throws Error(kOverwrite) if one of `files` is there, unless `overwrite`: for commands whose
// outputs are no stage's.
void RefuseToReplace(const std::vector<std::filesystem::path>& files, bool overwrite);

// Throws Error(kOverwrite) if `output` is one of `inputs`, or lies in one of them that is a folder:
// for commands that replace what is at their output path. Empty paths count as none.
void RefuseToReplaceInputs(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace lsmvs
