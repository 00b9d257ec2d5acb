#pragma once

#include <string>
#include <vector>

#include "lsmvs/colmap_adapter/workspace_files.h"

namespace lsmvs {

// What `--input_path` names: a folder (its fused.ply), or a cloud, PLY, whose workspace is its
// folder. Throws InputError if it is missing.
CloudInput FindCloudInput(const std::string& path);

// Several of them, in an order that depends on their contents only: that of the hashes of model,
// cloud and visibility. Several clouds may have the same model. With `sparse` there are no clouds,
// only models. Throws InputError if one is
// missing, UsageError if one is given twice, under whatever name.
std::vector<CloudInput> FindCloudInputs(const std::vector<std::string>& paths, bool sparse);

// One line for each model: which numbers its photos have in a visibility file about all.
std::string ViewNumbersText(const std::vector<CloudInput>& inputs, const std::vector<Scene>& parts);

}  // namespace lsmvs
