#pragma once

#include <Eigen/Core>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// What is up and where the viewer stands; both in the world, neither zero nor parallel.
struct ExportDirections {
  // COLMAP's first camera looks along z and has y downwards.
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  Eigen::Vector3d to_viewer = -Eigen::Vector3d::UnitZ();
};

// The axes of glTF: y up, the viewer at +z.
Eigen::Matrix3d YUpFromWorld(const ExportDirections& directions);
// The axes of 3D Tiles and of surveying: z up, the viewer at -y.
Eigen::Matrix3d ZUpFromWorld(const ExportDirections& directions);

// What to subtract from the coordinates before they are written in single precision: zero where
// that keeps them to 1e-6 of the mesh's size; else the middle of its box in whole units.
Eigen::Vector3d ExportOffset(const TriangleMesh& mesh);

}  // namespace lsmvs
