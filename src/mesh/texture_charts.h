#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

// Which faces lie side by side in the texture: a chart is a largest set of faces that are connected
// over edges whose texture coordinates agree (to 1/256 of a texel) on both sides.
struct TextureCharts {
  std::vector<int32_t> chart_of_face;  // #F; numbered in the order of their lowest face
  int num_charts = 0;
};

// O(#F). Faces of a mesh without texture have no charts.
TextureCharts FindTextureCharts(const TexturedMesh& textured);

// Whether two faces continue each other in the texture over the edge between two of their vertices.
bool ContinueInTexture(const TexturedMesh& textured, int face, int other_face, int vertex_a,
                       int vertex_b);

}  // namespace lsmvs
