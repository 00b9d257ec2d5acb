#include "lsmvs/mesh/inspect.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include "lsmvs/util/check.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

struct HalfEdge {
  int low, high;
  bool forward;  // runs from low to high
};

std::vector<HalfEdge> SortedHalfEdges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const int a = face[k], b = face[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  return edges;
}

void CountEdges(const TriangleMesh& mesh, MeshInspection* result) {
  const std::vector<HalfEdge> edges = SortedHalfEdges(mesh);
  for (size_t begin = 0; begin < edges.size();) {
    size_t end = begin, num_forward = 0;
    while (end < edges.size() && edges[end].low == edges[begin].low &&
           edges[end].high == edges[begin].high) {
      num_forward += edges[end++].forward;
    }
    const size_t count = end - begin;
    ++result->num_edges;
    result->num_border_edges += (count == 1);
    result->num_nonmanifold_edges += (count > 2);
    result->num_misoriented_edges += (count == 2 && num_forward != 1);
    begin = end;
  }
}

// Groups the corners of each vertex by the edges that they share; a manifold vertex has one group.
void CountVerticesAndComponents(const TriangleMesh& mesh, MeshInspection* result) {
  struct Spoke {
    int center, rim;
    size_t corner;
  };
  std::vector<Spoke> spokes;
  spokes.reserve(6 * mesh.faces.size());
  DisjointSets components(mesh.vertices.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3i& face = mesh.faces[f];
      spokes.push_back({face[k], face[(k + 1) % 3], 3 * f + k});
      spokes.push_back({face[k], face[(k + 2) % 3], 3 * f + k});
      components.Unite(face[k], face[(k + 1) % 3]);
    }
  }
  std::sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) {
    return std::tie(a.center, a.rim, a.corner) < std::tie(b.center, b.rim, b.corner);
  });
  DisjointSets fans(3 * mesh.faces.size());
  for (size_t i = 1; i < spokes.size(); ++i) {
    if (spokes[i].center == spokes[i - 1].center && spokes[i].rim == spokes[i - 1].rim) {
      fans.Unite(static_cast<uint32_t>(spokes[i].corner),
                 static_cast<uint32_t>(spokes[i - 1].corner));
    }
  }
  std::vector<size_t> num_fans(mesh.vertices.size(), 0);
  for (size_t corner = 0; corner < 3 * mesh.faces.size(); ++corner) {
    if (fans.Find(static_cast<uint32_t>(corner)) == corner)
      ++num_fans[mesh.faces[corner / 3][corner % 3]];
  }
  for (size_t v = 0; v < num_fans.size(); ++v) {
    result->num_unused_vertices += (num_fans[v] == 0);
    result->num_nonmanifold_vertices += (num_fans[v] > 1);
    result->num_components += (num_fans[v] > 0 && components.Find(static_cast<uint32_t>(v)) == v);
  }
}

void MeasureFaces(const TriangleMesh& mesh, MeshInspection* result) {
  // Relative to one vertex: the volume of a closed mesh does not depend on it, its rounding does.
  const Eigen::Vector3d origin =
      mesh.vertices.empty() ? Eigen::Vector3d(0, 0, 0) : mesh.vertices[0];
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, f);
    result->area += 0.5 * normal.norm();
    result->volume += normal.dot(mesh.vertices[face[0]] - origin) / 6.0;
    result->num_degenerate_faces +=
        (face[0] == face[1] || face[1] == face[2] || face[2] == face[0] || normal.isZero(0.0));
  }
}

size_t CountDuplicateFaces(const TriangleMesh& mesh) {
  std::vector<std::array<int, 3>> keys;
  keys.reserve(mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    std::array<int, 3> key = {face[0], face[1], face[2]};
    std::sort(key.begin(), key.end());
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  size_t count = 0;
  for (size_t i = 1; i < keys.size(); ++i) count += (keys[i] == keys[i - 1]);
  return count;
}

}  // namespace

MeshInspection Inspect(const TriangleMesh& mesh) {
  const int num_vertices = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (const int v : face) {
      LSMVS_CHECK_GE(v, 0);
      LSMVS_CHECK_LT(v, num_vertices);
    }
  }
  MeshInspection result;
  result.num_vertices = mesh.vertices.size();
  result.num_faces = mesh.faces.size();
  CountEdges(mesh, &result);
  CountVerticesAndComponents(mesh, &result);
  MeasureFaces(mesh, &result);
  result.num_duplicate_faces = CountDuplicateFaces(mesh);
  result.euler_characteristic =
      static_cast<long>(result.num_vertices - result.num_unused_vertices) -
      static_cast<long>(result.num_edges) + static_cast<long>(result.num_faces);
  return result;
}

}  // namespace lsmvs
