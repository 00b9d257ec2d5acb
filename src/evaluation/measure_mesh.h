#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/evaluation/evaluation_text.h"
#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Groups of the figures that belong together; each function sets those of its own in `figures`.

// Surface and depth errors. Depth is compared where both are meshes (`tracer`, of `mesh`, is null
// for a cloud) and there are views.
void MeasureAgainstTruth(const SurfaceEvaluator& truth, const TriangleMesh& mesh,
                         const MeshTracer* tracer, const std::vector<View>& views,
                         const DepthErrorOptions& options, const RunContext& context,
                         MeshFigures* figures);

// How well the texture, or without `pages` the vertex colours, shows the photos; of a texture also
// its seams and how well its pages are used. `tracer` is that of `mesh`. `view_idxs`: the views
// that are scored, all if empty.
void MeasureColors(const MeshTracer& tracer, const TriangleMesh& mesh, const TexturePages* pages,
                   const Scene& scene, const ImageStore& images, const std::vector<int>& view_idxs,
                   const TextureScoreOptions& options, const RunContext& context,
                   MeshFigures* figures);

// Distance of each position to the truth, in world units; NaN where it is not finite.
std::vector<double> DistancesToTruth(const SurfaceEvaluator& truth,
                                     const std::vector<Eigen::Vector3d>& x_in_world,
                                     const RunContext& context);

}  // namespace lsmvs
