#include "lsmvs/mesh/repair.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

// Side k of a face, from corner k to the next.
struct Side {
  int low, high;
  uint32_t corner;  // 3 * face + k
  bool operator<(const Side& other) const {
    if (low != other.low) return low < other.low;
    return high != other.high ? high < other.high : corner < other.corner;
  }
  bool SameEdge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> SortedSides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<uint32_t>(3 * f + k)});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
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
  const std::vector<Side> sides = SortedSides(*mesh);
  for (size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin + 1; end < sides.size() && sides[end].SameEdge(sides[begin]);) ++end;
    if (end - begin == 2) JoinAcross(*mesh, sides[begin].corner, sides[begin + 1].corner, &fans);
  }
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
  const std::vector<Side> sides = SortedSides(mesh);
  for (size_t i = 0; i < sides.size(); ++i) {
    const bool border = (i == 0 || !sides[i].SameEdge(sides[i - 1])) &&
                        (i + 1 == sides.size() || !sides[i].SameEdge(sides[i + 1]));
    if (!border) continue;
    const uint32_t from = sides[i].corner, to = NextCorner(from);
    next[mesh.faces[to / 3][to % 3]] = mesh.faces[from / 3][from % 3];
  }
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
