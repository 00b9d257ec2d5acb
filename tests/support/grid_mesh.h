#pragma once

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// A flat square of n x n vertices at z = 0, `spacing` apart, facing up: 2 (n - 1)^2 faces.
inline TriangleMesh GridMesh(int n, double spacing = 1) {
  TriangleMesh mesh;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) mesh.vertices.push_back({x * spacing, y * spacing, 0});
  }
  for (int y = 0; y + 1 < n; ++y) {
    for (int x = 0; x + 1 < n; ++x) {
      const int a = y * n + x;
      mesh.faces.push_back({a, a + 1, a + n});
      mesh.faces.push_back({a + 1, a + n + 1, a + n});
    }
  }
  return mesh;
}

// Middle of a face.
inline Eigen::Vector3d FaceMiddle(const TriangleMesh& mesh, size_t f) {
  const Eigen::Vector3i& face = mesh.faces[f];
  return (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
}

}  // namespace lsmvs
