#pragma once

#include <string>
#include <vector>

#include "lsmvs/evaluation/depth_errors.h"
#include "lsmvs/evaluation/photometric_score.h"
#include "lsmvs/evaluation/surface_evaluator.h"
#include "lsmvs/evaluation/texture_score.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct MeshEvaluationOptions {
  // Mesh or cloud (PLY), or a result of PMVS (IsPmvsResult).
  std::string input_path;
  // True mesh or cloud (PLY); empty: the photos alone judge.
  std::string ground_truth_path;
  // Workspace with cameras and photos, or a folder of PMVS; empty: the input's, if that is such a
  // folder, else none.
  std::string workspace_path;
  bool photometric = false;  // compare with the photos although there is a truth
  // Photos that are scored; empty: every `view_step`-th by name, the first one included.
  std::vector<std::string> view_names;
  int view_step = 1;
  bool texture = false;    // score texture or vertex colours
  std::string json_path;   // figures as JSON; "-": printed in place of the tables
  std::string error_path;  // mesh with its errors as vertex colours (PLY)
  // Folder of the scratch file of meshes that do not fit into memory; empty: the system's for
  // temporary files.
  std::string scratch_path;
  SurfaceEvaluationOptions surface;
  DepthErrorOptions depth;
  PhotometricOptions photo;
  TextureScoreOptions texture_score;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

// Scores a mesh or a cloud against a truth, the photos, or both, and prints the figures as tables.
// Throws UsageError for options out of range or that do not go together, InputError for input that
// cannot be scored so.
void EvaluateMesh(const MeshEvaluationOptions& options, const CommandContext& context);

}  // namespace lsmvs
