#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/refinement/photo/photo_energy.h"
#include "lsmvs/refinement/regions/face_regions.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct RollbackSummary {
  size_t num_regions_restored = 0;
  // Mean of 1 - ZNCC over the judging pairs: before, and after what got worse was restored.
  double input_error = 0, output_error = 0;
};

// What a refined surface gained in smoothness, which may outweigh a loss of photo-consistency: an
// input that fits the noise of the photos has a low photo error and is rough.
struct SmoothnessGain {
  // #V: energy of the thin plate at the input minus that of the refined mesh, in units of 1 - ZNCC
  // summed over the pixels of the judging pairs. Empty: 0.
  std::vector<double> of_vertex;
};

// Compares the photo error of every region of a refined mesh with that of the same faces at their
// `input` positions, over the pairs given (best such as took no part in the refinement). Regions
// whose mean error rose by more than noise and, up to a twentieth, what they gained in smoothness
// explain, or that lost many of their judged pixels, return to their input. Around them the
// displacement fades out over a few rings of vertices, so that no step is left.
RollbackSummary RollBackWorseRegions(const ImageStore& images,
                                     const std::vector<PosedCamera>& views,
                                     const FaceRegions& regions, const FacePairs& pairs,
                                     const std::vector<Eigen::Vector3d>& input,
                                     const SmoothnessGain& gain, const PhotoEnergyOptions& options,
                                     TriangleMesh* mesh, const RunContext& context);

}  // namespace lsmvs
