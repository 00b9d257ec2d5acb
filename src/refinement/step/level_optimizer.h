#pragma once

#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/refinement/photo/photo_energy.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Views of the scene at one level of the store.
std::vector<PosedCamera> MakeLevelViews(const Scene& scene, const ImageStore& images, int level);

PhotoEnergyOptions MakePhotoEnergyOptions(const MeshRefinerOptions& options, int level,
                                          const RunContext& context);

// Moves the vertices of `mesh` along their normals at one pyramid level until the regions have
// converged. The topology stays. `regions` and `pairs` belong to this mesh and level. `input` (#V)
// is where the vertices came from: a weak spring ties them to it, so that they stay where neither
// photos nor smoothness say otherwise.
RefinementLevelSummary OptimizeLevel(const ImageStore& images,
                                     const std::vector<PosedCamera>& views,
                                     const FaceRegions& regions, const FacePairs& pairs,
                                     const std::vector<Eigen::Vector3d>& input,
                                     const MeshRefinerOptions& options, int level,
                                     TriangleMesh* mesh, const RunContext& context);

}  // namespace lsmvs
