#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/evaluation/depth_errors.h"
#include "lsmvs/evaluation/photometric_score.h"
#include "lsmvs/evaluation/surface_evaluator.h"
#include "lsmvs/program/command.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct ComparisonOptions {
  std::string workspace_path;
  // True mesh or cloud; empty: the photos alone judge.
  std::string ground_truth_path;
  // Further meshes or clouds, separated by commas; results of PMVS as IsPmvsResult() knows them.
  std::string input_paths;
  // Folder of the report; empty: lsmvs/report in the workspace.
  std::string output_path;
  // Folder of the scratch file of meshes that do not fit into memory; empty: the system's for
  // temporary files.
  std::string scratch_path;
  // Title of the page; empty: made from the workspace's name.
  std::string title;
  // Photos that the photometric score is measured on, separated by commas; empty: all.
  std::string view_names;
  // Runs COLMAP's meshers whose result is missing, and leaves it where COLMAP would.
  bool run_colmap = false;
  // Faces of each mesh on the page; larger meshes are simplified for it, not for the figures.
  int max_num_faces = 200000;
  // Photos on the page; the poses of the others are there without picture.
  int max_num_photos = 40;
  // Longer side of the photos on the page, in pixels.
  int max_photo_size = 960;
  // Width of the pictures beside the page, in pixels.
  int picture_width = 1280;
  SurfaceEvaluationOptions surface;
  DepthErrorOptions depth;
  PhotometricOptions photo;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

// Finds the meshes of the workspace, and what PMVS made in its folder pmvs/, measures each, and
// writes index.html, report.json and a picture of each mesh; of clouds there are figures only.
// Returns the path of the page (of report.json if this build has no page).
// Throws InputError if there is no mesh. What could not be compared, and why, stands in the report.
std::filesystem::path WriteComparison(const ComparisonOptions& options,
                                      const CommandContext& context);

}  // namespace lsmvs
