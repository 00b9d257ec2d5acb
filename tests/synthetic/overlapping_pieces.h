#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Pieces of known surfaces, as reconstructions of different runs would show them.

// The faces whose middle is in the piece, without unused vertices.
TriangleMesh CutPiece(const TriangleMesh& whole,
                      const std::function<bool(const Eigen::Vector3d& middle)>& is_in);

// Moves vertices along their normals by Gaussian noise of a standard deviation of `sigma`:
// independent of each other, or with a `correlation_length` > 0 smooth over about that distance.
void AddNormalNoise(double sigma, double correlation_length, uint64_t seed, TriangleMesh* mesh);

// A hilly square [0, 10] x [0, 6], facing up; vertices are spread at random about a grid of the
// edge length, diagonals too.
TriangleMesh ReliefMesh(double edge_length, uint64_t seed);
// Height of that relief.
double ReliefHeight(double x, double y);

}  // namespace lsmvs
