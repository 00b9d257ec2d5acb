#pragma once

#include <string>
#include <vector>

#include "lsmvs/merging/mesh_merger.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct MeshMergingOptions {
  std::vector<std::string> input_paths;  // two or more meshes (PLY)
  std::string output_path;
  // Dense workspace with the photos that the inputs' .vis files number; empty: views are only
  // carried over.
  std::string workspace_path;
  bool overwrite = false;
  // Folder of the scratch file of meshes that do not fit into memory; empty: the system's for
  // temporary files.
  std::string scratch_path;
  MeshMergerOptions merging;

  void Describe(OptionSet* options);
};

// Merges meshes, with the views of their vertices where these are known: from the .vis file of each
// mesh, or by its cameras. A mesh that lies in a dense workspace of its own has the photos of that
// one; they are renumbered by name. Prints counts. Throws UsageError, Error(kOverwrite),
// InputError, and what MergeMeshes throws.
void MergeMeshFiles(const MeshMergingOptions& options, const CommandContext& context);

}  // namespace lsmvs
