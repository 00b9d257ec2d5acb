#include "lsmvs/mesh/repair.h"

#include <utility>

#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

// 3 * face + corner.
uint32_t CornerOf(const HalfEdge& side) {
  return 3 * static_cast<uint32_t>(side.face) + static_cast<uint32_t>(side.corner);
}

uint32_t NextCorner(uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

// Joins the corners of two faces that share an edge, at both of its ends.
void JoinAcross(const TriangleMesh& mesh, uint32_t corner_a, uint32_t corner_b,
                DisjointSets* fans) {
  const auto vertex = [&](uint32_t corner) { return mesh.faces[corner / 3][corner % 3]; };
  uint32_t end_a = NextCorner(corner_a), end_b = NextCorner(corner_b);
  if (vertex(corner_a) != vertex(corner_b)) std::swap(corner_b, end_b);
  fans->Unite(corner_a, corner_b);
  fans->Unite(end_a, end_b);
}

template <class Attribute>
void CopyElement(std::vector<Attribute>* attribute, int index) {
  if (attribute->empty()) return;
  const Attribute value = (*attribute)[index];
  attribute->push_back(value);
}

}  // namespace

std::vector<int> SplitNonManifoldVertices(TriangleMesh* mesh) {
  DisjointSets fans(3 * mesh->faces.size());
  ForEdges(SortedHalfEdges(mesh->faces, mesh->vertices.size()),
           [&](const HalfEdge* begin, const HalfEdge* end) {
             if (end - begin == 2) JoinAcross(*mesh, CornerOf(begin[0]), CornerOf(begin[1]), &fans);
           });
  std::vector<int> vertex_of_fan(3 * mesh->faces.size(), -1), sources;
  std::vector<bool> taken(mesh->vertices.size(), false);
  for (uint32_t corner = 0; corner < vertex_of_fan.size(); ++corner) {
    int& vertex = mesh->faces[corner / 3][corner % 3];
    int& copy = vertex_of_fan[fans.Find(corner)];
    if (copy < 0 && !taken[vertex]) {
      taken[vertex] = true;
      copy = vertex;
    } else if (copy < 0) {
      copy = static_cast<int>(mesh->vertices.size());
      sources.push_back(vertex);
      CopyElement(&mesh->vertices, vertex);
      CopyElement(&mesh->vertex_colors, vertex);
      CopyElement(&mesh->vertex_normals, vertex);
      CopyElement(&mesh->vertex_quality, vertex);
    }
    vertex = copy;
  }
  return sources;
}

MeshComponents FindComponents(const TriangleMesh& mesh) {
  DisjointSets sets(mesh.vertices.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    sets.Unite(face[0], face[1]);
    sets.Unite(face[1], face[2]);
  }
  MeshComponents components;
  std::vector<int> number(mesh.vertices.size(), -1);
  for (const Eigen::Vector3i& face : mesh.faces) {
    int& component = number[sets.Find(face[0])];
    if (component < 0) {
      component = static_cast<int>(components.num_faces.size());
      components.num_faces.push_back(0);
    }
    components.of_face.push_back(component);
    ++components.num_faces[component];
  }
  return components;
}

size_t FilterFaces(TriangleMesh* mesh, const std::function<bool(size_t face)>& keep) {
  size_t count = 0;
  for (size_t f = 0; f < mesh->faces.size(); ++f) {
    if (keep(f)) mesh->faces[count++] = mesh->faces[f];
  }
  const size_t num_dropped = mesh->faces.size() - count;
  mesh->faces.resize(count);
  return num_dropped;
}

std::vector<std::vector<int>> FindBorderLoops(const TriangleMesh& mesh) {
  // In a manifold each border vertex has one successor.
  std::vector<int> next(mesh.vertices.size(), -1);
  ForEdges(SortedHalfEdges(mesh.faces, mesh.vertices.size()),
           [&](const HalfEdge* begin, const HalfEdge* end) {
             if (end - begin != 1) return;
             const Eigen::Vector3i& face = mesh.faces[static_cast<size_t>(begin->face)];
             next[face[(begin->corner + 1) % 3]] = face[begin->corner];
           });
  std::vector<std::vector<int>> loops;
  for (int v = 0; v < static_cast<int>(next.size()); ++v) {
    if (next[v] < 0) continue;
    std::vector<int> loop;
    int current = v;
    while (current >= 0 && next[current] >= 0) {
      loop.push_back(current);
      current = std::exchange(next[current], -1);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace lsmvs
