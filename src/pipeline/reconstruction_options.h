#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>

#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/stereo/fusion.h"
#include "lsmvs/stereo/patch_match.h"
#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

// As COLMAP's automatic_reconstructor: image sizes of 1000, 1600, 2400 and the full one; the lower
// two take fewer iterations.
enum class Quality { kLow, kMedium, kHigh, kExtreme };

// The stages, in order. Their names are those of the commands that run them alone.
enum class ReconstructionStage { kStereo, kFusion, kSurface, kRefinement };
inline constexpr const char* kStereoStage = "patch_match_stereo";
inline constexpr const char* kFusionStage = "stereo_fusion";
inline constexpr const char* kSurfaceStage = "visibility_mesher";
inline constexpr const char* kRefinementStage = "mesh_refiner";

// Everything that decides what a reconstruction gives.
struct ReconstructionOptions {
  // Longer side, pixels, to which photos are reduced in all stages; 0: as they are.
  int max_image_size = 2400;
  // Points outside are dropped, in the world of the files. Empty: none.
  Eigen::AlignedBox3d bounding_box;
  uint64_t seed = 0;

  ViewSelectionOptions view_selection;
  PatchMatchOptions patch_match;
  FusionOptions fusion;
  VisibilityMesherOptions surface;
  MeshRefinerOptions refinement;

  // The stages' options, "Group.field".
  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Sets what the quality decides and leaves the rest.
void ApplyQuality(Quality quality, ReconstructionOptions* options);

// "xmin,ymin,zmin,xmax,ymax,zmax" (commas or blanks). Throws UsageError that names `option`. An
// empty text is an empty box.
Eigen::AlignedBox3d ParseBox(const std::string& option, const std::string& text);

}  // namespace lsmvs
