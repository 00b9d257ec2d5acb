#include "lsmvs/merging/zip/hole_edges.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

size_t Index(int32_t i) { return static_cast<size_t>(i); }

// The fans of the faces at a vertex, by face.
std::map<int32_t, uint32_t> FansAt(std::span<const Eigen::Vector3i> faces, int32_t v,
                                   const std::vector<int32_t>& at_vertex) {
  DisjointSets sets(at_vertex.size());
  std::map<int32_t, uint32_t> face_at;  // by the other vertex of an edge at v
  for (uint32_t i = 0; i < at_vertex.size(); ++i) {
    for (const int32_t w : faces[Index(at_vertex[i])]) {
      if (w == v) continue;
      const auto [it, is_new] = face_at.emplace(w, i);
      if (!is_new) sets.Unite(i, it->second);
    }
  }
  std::map<int32_t, uint32_t> fans;
  for (uint32_t i = 0; i < at_vertex.size(); ++i) fans[at_vertex[i]] = sets.Find(i);
  return fans;
}

}  // namespace

std::vector<HoleEdge> FindHoleEdges(std::span<const Eigen::Vector3i> faces, size_t num_vertices) {
  std::vector<HoleEdge> edges;
  ForEdges(SortedHalfEdges(faces, num_vertices), [&](const HalfEdge* begin, const HalfEdge* end) {
    if (end - begin != 1) return;
    const Eigen::Vector3i& face = faces[Index(begin->face)];
    edges.push_back({face[(begin->corner + 1) % 3], face[begin->corner], begin->face});
  });
  std::sort(edges.begin(), edges.end(), [](const HoleEdge& a, const HoleEdge& b) {
    return std::tie(a.from, a.to) < std::tie(b.from, b.to);
  });
  return edges;
}

std::vector<size_t> HoleSuccessors(std::span<const Eigen::Vector3i> faces,
                                   const std::vector<HoleEdge>& edges) {
  const auto first_from = [&](int32_t v) {
    const auto at = std::lower_bound(edges.begin(), edges.end(), v,
                                     [](const HoleEdge& e, int32_t w) { return e.from < w; });
    return static_cast<size_t>(at - edges.begin());
  };
  std::map<int32_t, std::vector<int32_t>> faces_at;  // of vertices between several holes
  for (size_t e = 0; e + 1 < edges.size(); ++e) {
    if (edges[e].from == edges[e + 1].from) faces_at[edges[e].from];
  }
  for (size_t f = 0; f < faces.size() && !faces_at.empty(); ++f) {
    for (const int32_t v : faces[f]) {
      const auto found = faces_at.find(v);
      if (found != faces_at.end()) found->second.push_back(static_cast<int32_t>(f));
    }
  }
  std::vector<size_t> successors(edges.size());
  for (size_t e = 0; e < edges.size(); ++e) successors[e] = first_from(edges[e].to);
  for (const auto& [v, at_vertex] : faces_at) {
    const std::map<int32_t, uint32_t> fans = FansAt(faces, v, at_vertex);
    std::map<uint32_t, size_t> out_of;  // edge from v by the fan of its face
    for (size_t e = first_from(v); e < edges.size() && edges[e].from == v; ++e) {
      out_of[fans.at(edges[e].face)] = e;
    }
    for (size_t e = 0; e < edges.size(); ++e) {
      if (edges[e].to != v) continue;
      const auto next = out_of.upper_bound(fans.at(edges[e].face));
      successors[e] = next == out_of.end() ? out_of.begin()->second : next->second;
    }
  }
  return successors;
}

}  // namespace lsmvs
