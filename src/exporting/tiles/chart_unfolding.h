#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Part of a mesh laid flat.
struct UnfoldedChart {
  std::vector<int> faces;                                 // ascending
  std::vector<std::array<Eigen::Vector2f, 3>> texcoords;  // of the faces, within the chart [px]
  Eigen::Vector2i size = Eigen::Vector2i::Zero();         // with the gutter on all sides [px]
  // Per texel the face that it shows: that which its centre lies in, or else the nearest within
  // 1.5 texels; -1 for the rest. Positions in `faces`.
  Raster<int32_t> face_of_texel;
};

// Texels on each side of a chart.
inline constexpr int kChartGutterPx = 4;

// Lays all faces flat in charts without overlap: connected faces are projected along their mean
// normal, which none is turned away from by more than about 70 degrees, so that a texel covers at
// most three times its area on the surface. Texels are `texel_size` wide in the plane of the
// projection. For surfaces that are smooth at the scale of their faces, such as simplified ones.
// Deterministic. About O(#F + texels).
std::vector<UnfoldedChart> UnfoldCharts(const TriangleMesh& mesh, double texel_size);

}  // namespace lsmvs
