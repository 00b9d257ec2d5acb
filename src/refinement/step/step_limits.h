#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/mesh/vertex_rings.h"

namespace lsmvs {

// A surface before a step, all arrays #V but the faces. Steps are displacements x_v in pixels along
// the directions.
struct SurfaceBeforeStep {
  const TriangleMesh& mesh;
  const VertexRings& rings;
  const std::vector<Eigen::Vector3d>& input;       // where the vertices came from
  const std::vector<Eigen::Vector3d>& directions;  // unit length
  const std::vector<double>& pixel_size;           // > 0
  const std::vector<uint8_t>& fixed;               // 1: stays
  const std::vector<uint8_t>& on_rim;  // 1: at a border of the mesh, or of what pairs see
};

// Positions after a step, rounded as files do.
std::vector<Eigen::Vector3d> Displaced(const SurfaceBeforeStep& surface,
                                       const std::vector<double>& step);

// The windows at a rim lie half beyond it: vertices there go little further from the input than the
// surface beside them.
void HoldRims(const SurfaceBeforeStep& surface, std::vector<double>* step);

// Takes back the steps of faces that would turn away from the surface around them.
void StopFolds(const SurfaceBeforeStep& surface, std::vector<double>* step);

}  // namespace lsmvs
