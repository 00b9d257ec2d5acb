#pragma once

#include <optional>
#include <string>

#include "lsmvs/mesh/simplify.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct MeshSimplificationOptions {
  std::string input_path, output_path;  // PLY
  // With it `max_error` is in pixels, else in the unit of the file.
  std::string workspace_path;
  bool overwrite = false;
  // Largest distance between the surfaces; nothing: 0.25 pixels, or no bound with a target ratio.
  std::optional<double> max_error;
  // Folder of the scratch file of a mesh that does not fit into memory; empty: the system's for
  // temporary files.
  std::string scratch_path;
  BoundedSimplificationOptions simplification;

  void Describe(OptionSet* options);
};

// Simplifies a mesh and, if INPUT.vis is there, gives OUTPUT.vis the views of each vertex that
// stays. Prints the number of faces. Throws UsageError for options that do not go together,
// Error(kOverwrite) if an output is there, InputError for input that is no mesh.
void SimplifyMeshFile(const MeshSimplificationOptions& options, const CommandContext& context);

}  // namespace lsmvs
