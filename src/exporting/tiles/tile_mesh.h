#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// What a tile shows: a mesh in the world with a page of its own, or with vertex colours.
struct TileMesh {
  TriangleMesh mesh;
  // #V: which vertex of the finest mesh it is; -1 for those that simplification made.
  std::vector<int> vertex_ids;
  std::vector<std::array<Eigen::Vector2f, 3>> texcoords;  // #F [px of the page], or empty
  ColorImage page;                                        // sides are multiples of 8; or empty
  double texel_size = 0;  // mean width of a texel on the surface (of an edge without texture)
  double error = 0;       // bound on the distance to the finest mesh, both ways

  bool has_texture() const { return !page.empty(); }
};

// Area of a triangle in the plane, without sign.
inline double TriangleArea(const std::array<Eigen::Vector2f, 3>& t) {
  const Eigen::Vector2d a = (t[1] - t[0]).cast<double>(), b = (t[2] - t[0]).cast<double>();
  return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

// Mean width of a texel on the surface (root of area over texels); 0 if the texture has no area.
double MeanTexelSize(const TriangleMesh& mesh,
                     const std::vector<std::array<Eigen::Vector2f, 3>>& texcoords);

}  // namespace lsmvs
