#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs::test {

// A rectangle [0, width] x [0, height] at height z, in n x n cells of two triangles, seen from
// above.
inline TriangleMesh PlaneMesh(double width, double height, double z, int n = 4) {
  TriangleMesh mesh;
  for (int row = 0; row <= n; ++row) {
    for (int column = 0; column <= n; ++column) {
      mesh.vertices.emplace_back(width * column / n, height * row / n, z);
    }
  }
  const auto index = [n](int column, int row) { return row * (n + 1) + column; };
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const int a = index(column, row), b = index(column + 1, row);
      const int c = index(column, row + 1), d = index(column + 1, row + 1);
      mesh.faces.emplace_back(a, b, d);
      mesh.faces.emplace_back(a, d, c);
    }
  }
  return mesh;
}

// A sphere about the origin by longitude and latitude.
inline TriangleMesh SphereMesh(double radius, int n = 96) {
  TriangleMesh mesh;
  const int columns = 2 * n;
  for (int row = 0; row <= n; ++row) {
    const double polar = std::numbers::pi * row / n;
    for (int column = 0; column < columns; ++column) {
      const double azimuth = 2 * std::numbers::pi * column / columns;
      mesh.vertices.emplace_back(radius * std::sin(polar) * std::cos(azimuth),
                                 radius * std::sin(polar) * std::sin(azimuth),
                                 radius * std::cos(polar));
    }
  }
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int a = row * columns + column, b = row * columns + (column + 1) % columns;
      if (row > 0) mesh.faces.emplace_back(a, a + columns, b);
      if (row < n - 1) mesh.faces.emplace_back(b, a + columns, b + columns);
    }
  }
  return mesh;
}

// A view from `center` down the negative z axis.
inline View DownwardView(const Eigen::Vector3d& center, int width = 200, int height = 200,
                         double focal = 200) {
  View view;
  view.camera = {width, height, focal, focal, 0.5 * width, 0.5 * height};
  Eigen::Matrix3d rotation;
  rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  view.cam_from_world = Rigid3(rotation, -rotation * center);
  return view;
}

inline TriangleMesh Scaled(TriangleMesh mesh, double scale, const Eigen::Vector3d& shift) {
  for (Eigen::Vector3d& x : mesh.vertices) x = scale * x + shift;
  return mesh;
}

}  // namespace lsmvs::test
