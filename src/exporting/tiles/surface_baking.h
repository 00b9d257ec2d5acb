#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// A texture on one page for a whole mesh.
struct BakedSurface {
  std::vector<std::array<Eigen::Vector2f, 3>> texcoords;  // #F [px of the page]
  ColorImage page;
};

// The colour [grey levels] of a point of the mesh with the normal of its face (of any length).
using ColorAt =
    std::function<Eigen::Vector3f(const Eigen::Vector3d& x, const Eigen::Vector3d& normal)>;

// Lays the faces flat (UnfoldCharts), packs them and asks for the colour of the point of each
// texel. `color_at` is called from several threads. Throws UsageError if the page would be
// wider than 16,384 pixels.
BakedSurface BakeSurface(const TriangleMesh& mesh, double texel_size, const ColorAt& color_at,
                         const RunContext& context);

// Width of a texel with which a mesh takes about `max_texels`.
double TexelSizeFor(const TriangleMesh& mesh, double max_texels);

}  // namespace lsmvs
