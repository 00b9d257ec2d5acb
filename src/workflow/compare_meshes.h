#pragma once

#include <string>
#include <vector>

#include "lsmvs/program/command_context.h"
#include "lsmvs/report/report_builder.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct MeshComparisonOptions {
  std::string workspace_path;
  // True mesh or cloud; empty: the photos alone judge.
  std::string ground_truth_path;
  // Further meshes or clouds; results of PMVS as IsPmvsResult() knows them.
  std::vector<std::string> input_paths;
  // Folder of the report; empty: lsmvs/report in the workspace.
  std::string output_path;
  // Folder of the scratch file of meshes that do not fit into memory; empty: the system's for
  // temporary files.
  std::string scratch_path;
  // Title of the page; empty: made from the workspace's name.
  std::string title;
  // Photos that the photometric score is measured on; empty: all.
  std::vector<std::string> view_names;
  // Runs COLMAP's meshers whose result is missing, and leaves it where COLMAP would.
  bool run_colmap = false;
  ReportOptions report;  // its view_idxs come from view_names

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

// Finds the meshes of the workspace, and what PMVS made in its folder pmvs/, measures each, and
// writes index.html, report.json and a picture of each mesh; of clouds there are figures only.
// Prints the path of the page (of report.json if this build has no page). Throws InputError if
// there is no mesh. What could not be compared, and why, stands in the report.
void CompareMeshes(const MeshComparisonOptions& options, const CommandContext& context);

}  // namespace lsmvs
