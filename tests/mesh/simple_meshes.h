#pragma once

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// An octahedron whose faces are split into four `levels` times, on the unit sphere; outward.
inline TriangleMesh SphereMesh(int levels) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [it, is_new] = middles.try_emplace(std::pair<int, int>(std::minmax(a, b)),
                                                    static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return it->second;
    };
    std::vector<Eigen::Vector3i> faces;
    for (const Eigen::Vector3i& f : mesh.faces) {
      const int a = middle(f[0], f[1]), b = middle(f[1], f[2]), c = middle(f[2], f[0]);
      faces.insert(faces.end(), {{f[0], a, c}, {a, f[1], b}, {c, b, f[2]}, {a, b, c}});
    }
    mesh.faces.swap(faces);
  }
  return mesh;
}

// A surface over the unit square, n x n squares of two faces each.
template <class Place>
TriangleMesh UnitSquareMesh(int n, const Place& place) {
  TriangleMesh mesh;
  for (int row = 0; row <= n; ++row) {
    for (int column = 0; column <= n; ++column) {
      mesh.vertices.push_back(place(static_cast<double>(column) / n, static_cast<double>(row) / n));
    }
  }
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const int a = row * (n + 1) + column, c = a + n + 1;
      mesh.faces.emplace_back(a, a + 1, c + 1);
      mesh.faces.emplace_back(a, c + 1, c);
    }
  }
  return mesh;
}

}  // namespace lsmvs
