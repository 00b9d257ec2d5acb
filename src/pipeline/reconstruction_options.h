#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/scene/workspace_files.h"
#include "lsmvs/stereo/fusion.h"
#include "lsmvs/stereo/patch_match.h"
#include "lsmvs/stereo/quasi_dense_matcher.h"
#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/texturing/mesh_texturer.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

// As COLMAP's automatic_reconstructor: image sizes of 1000, 1600, 2400 and the full one; the lower
// two take fewer iterations. The lowest takes its points from quasi-dense matching.
enum class Quality { kLow, kMedium, kHigh, kExtreme };

// Where the cloud comes from: depth maps and their fusion, or interest points, which takes about a
// quarter of the time and memory and gives an eighth of the points.
enum class PointSource { kPatchMatch, kQuasiDense };

// The stages, in order. Their names are those of the commands that run them alone.
enum class ReconstructionStage { kStereo, kFusion, kQuasiDense, kSurface, kRefinement, kTexturing };
inline constexpr const char* kStereoStage = "patch_match_stereo";
inline constexpr const char* kFusionStage = "stereo_fusion";
inline constexpr const char* kQuasiDenseStage = "quasi_dense_matcher";
inline constexpr const char* kSurfaceStage = "visibility_mesher";
inline constexpr const char* kRefinementStage = "mesh_refiner";
inline constexpr const char* kTexturingStage = "mesh_texturer";

const char* StageName(ReconstructionStage stage);
// The stages that lead from photos to a textured mesh by way of this source, in order. The last one
// is left out unless somebody asks for it.
std::vector<ReconstructionStage> StagesOf(PointSource source);
// Throws UsageError if one of the two is no stage of that source, or `from` comes after `to`.
void CheckStages(PointSource source, ReconstructionStage from, ReconstructionStage to);

// Everything that decides what a reconstruction gives.
struct ReconstructionOptions {
  // Longer side, pixels, to which photos are reduced in all stages; 0: as they are.
  int max_image_size = 2400;
  // Points outside are dropped, in the world of the files. Empty: none.
  Eigen::AlignedBox3d bounding_box;
  uint64_t seed = 0;
  PointSource point_source = PointSource::kPatchMatch;
  // Photometric maps serve the geometric pass only. COLMAP keeps them.
  bool keep_photometric_maps = true;
  MapPrecision map_precision = MapPrecision::kExact;

  ViewSelectionOptions view_selection;
  PatchMatchOptions patch_match;
  FusionOptions fusion;
  QuasiDenseOptions quasi_dense;
  VisibilityMesherOptions surface;
  MeshRefinerOptions refinement;
  MeshTexturerOptions texturing;

  // The stages' options, "Group.field".
  void Describe(OptionSet* options);
  bool Check(std::string* error) const {
    return CheckOptions(*this, error) && texturing.Check(error);
  }
};

// Sets what the quality decides and leaves the rest.
void ApplyQuality(Quality quality, ReconstructionOptions* options);

}  // namespace lsmvs
