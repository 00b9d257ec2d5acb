#pragma once

#include <cstddef>
#include <string>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// What a mesh is like, combinatorially and in size.
struct MeshInspection {
  size_t num_vertices = 0, num_faces = 0, num_edges = 0;
  size_t num_unused_vertices = 0;
  size_t num_degenerate_faces = 0;      // a vertex twice, or area exactly 0
  size_t num_border_edges = 0;          // with one face
  size_t num_nonmanifold_edges = 0;     // with more than two faces
  size_t num_misoriented_edges = 0;     // whose two faces run along it in the same direction
  size_t num_nonmanifold_vertices = 0;  // whose faces form more than one fan
  size_t num_components = 0;            // connected over vertices; unused vertices do not count
  size_t num_duplicate_faces = 0;       // same three vertices as another face
  double area = 0;
  double volume = 0;              // signed, positive if closed and oriented outward
  long euler_characteristic = 0;  // V - E + F over used vertices

  bool IsManifold() const { return num_nonmanifold_edges == 0 && num_nonmanifold_vertices == 0; }
  bool IsOriented() const { return num_misoriented_edges == 0 && num_nonmanifold_edges == 0; }
  bool IsClosed() const { return num_border_edges == 0 && num_nonmanifold_edges == 0; }
  // For a closed, oriented, connected manifold.
  long Genus() const { return (2 - euler_characteristic) / 2; }
};

// O(F log F). Faces with indices out of range throw std::logic_error.
MeshInspection Inspect(const TriangleMesh& mesh);

}  // namespace lsmvs
