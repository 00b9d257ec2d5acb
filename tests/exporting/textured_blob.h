#pragma once

#include <cmath>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/synthetic/analytic_shapes.h"

namespace lsmvs {

// A potato without any symmetry, so that a flip of an axis or of the texture shows; about
// 15 / edge_length^2 faces.
inline TriangleMesh BlobMesh(double edge_length) {
  TriangleMesh mesh = Sphere({0, 0, 0}, 1.0).Mesh(edge_length);
  for (Eigen::Vector3d& x : mesh.vertices) {
    const double r = 1 + 0.12 * std::sin(3 * x.x() + 1) + 0.1 * std::sin(4 * x.y() + x.z()) +
                     0.08 * x.x() * x.z();
    x = r * x.cwiseProduct(Eigen::Vector3d(1.2, 1, 0.8));
  }
  return mesh;
}

// Colours that differ everywhere, with waves of 0.16 that show a shift of half a texel.
inline Color BlobColor(const Eigen::Vector3d& x) {
  const double fine = 25 * std::sin(40 * x.x()) * std::sin(40 * x.y() + 40 * x.z());
  return Color(static_cast<uint8_t>(128 + fine + 90 * std::sin(2.3 * x.x() + x.y())),
               static_cast<uint8_t>(128 + fine + 90 * std::sin(3.1 * x.y() - 0.5 * x.z())),
               static_cast<uint8_t>(128 - fine + 90 * std::cos(2.7 * x.z() + 0.8 * x.x())));
}

}  // namespace lsmvs
