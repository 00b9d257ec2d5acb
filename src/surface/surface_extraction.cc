#include "lsmvs/surface/surface_extraction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "lsmvs/util/check.h"
#include "lsmvs/util/disjoint_sets.h"
#include "lsmvs/util/scratch_memory.h"

namespace lsmvs {

namespace {

struct Facet {
  int32_t cell;  // the full one
  int8_t index;
  std::array<int32_t, 3> vertex;   // counter-clockwise from the empty side
  std::array<int32_t, 3> partner;  // facet across the edge vertex[k] - vertex[k+1]; -1 at the hull
};

class Extractor {
 public:
  explicit Extractor(Tetrahedralization* complex) : complex_(*complex) {}

  ExtractedSurface Run() {
    CollectFacets();
    result_.num_cut_facets = facets_.size();
    PairFacets();
    std::vector<Cell>().swap(complex_.cells);
    NumberCorners();
    WriteMesh();
    SplitSharedEdges();
    return std::move(result_);
  }

 private:
  bool Full(int32_t cell) const { return !complex_.cells[cell].OnSourceSide(); }
  // Between full and empty, and not at infinity.
  bool OnSurface(int32_t cell, int i) const {
    const int32_t other = complex_.cells[cell].neighbor[i];
    return Full(cell) && !Full(other) && !(complex_.IsInfinite(cell) && complex_.IsInfinite(other));
  }

  void CollectFacets() {
    // Two facets a vertex on a closed surface. An array that grows takes three times its bytes,
    // and the cells are still there.
    facets_.reserve(complex_.points.size() * 22 / 10 + 64);
    for (int32_t c = 0; c < static_cast<int32_t>(complex_.cells.size()); ++c) {
      if (!Full(c)) continue;
      for (int8_t i = 0; i < 4; ++i) {
        if (OnSurface(c, i)) facets_.push_back(MakeFacet(c, i));
      }
    }
    ScratchMemory::GiveBackTail(facets_.data(), facets_.size() * sizeof(Facet));
    std::sort(facets_.begin(), facets_.end(),
              [](const Facet& a, const Facet& b) { return a.vertex < b.vertex; });
  }

  Facet MakeFacet(int32_t c, int8_t i) const {
    const Cell& cell = complex_.cells[c];
    Facet facet{c, i, {}, {-1, -1, -1}};
    // From inside counter-clockwise, so clockwise from outside: reversed. In a cell at infinity the
    // table's order holds too.
    for (int k = 0; k < 3; ++k) facet.vertex[k] = cell.vertex[kFacetVertices[i][2 - k]];
    auto& v = facet.vertex;
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    return facet;
  }

  // Around the edge through full cells to the facet where they end.
  std::pair<int32_t, int> Opposite(const Facet& facet, int k) const {
    const int32_t a = facet.vertex[k], b = facet.vertex[(k + 1) % 3];
    int32_t c = facet.cell;
    int from = facet.index;
    while (true) {
      const Cell& cell = complex_.cells[c];
      // The other facet at the edge: opposite to the vertex that is neither a, b nor opposite to
      // `from`.
      int to = 0;
      while (to == from || cell.vertex[to] == a || cell.vertex[to] == b) ++to;
      const int32_t next = cell.neighbor[to];
      if (!Full(next)) return OnSurface(c, to) ? std::pair(c, to) : std::pair(-1, 0);
      from = cell.Reverse(to);
      c = next;
    }
  }

  void PairFacets() {
    // The cut is done: the capacities of the cells can hold the facets' positions.
    for (size_t f = 0; f < facets_.size(); ++f) {
      complex_.cells[facets_[f].cell].capacity[facets_[f].index] = static_cast<int32_t>(f);
    }
    for (Facet& facet : facets_) {
      for (int k = 0; k < 3; ++k) {
        const auto [cell, index] = Opposite(facet, k);
        facet.partner[k] = cell < 0 ? -1 : complex_.cells[cell].capacity[index];
      }
    }
  }

  uint32_t CornerOf(size_t f, int32_t vertex) const {
    const auto& v = facets_[f].vertex;
    return static_cast<uint32_t>(3 * f + (v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2));
  }

  // One mesh vertex for each fan of corners that are joined across edges.
  void NumberCorners() {
    const auto num_corners = static_cast<uint32_t>(3 * facets_.size());
    DisjointSets fan_sets(num_corners);
    for (size_t f = 0; f < facets_.size(); ++f) {
      for (int k = 0; k < 3; ++k) {
        const int32_t partner = facets_[f].partner[k];
        if (partner < 0) continue;
        for (const int32_t v : {facets_[f].vertex[k], facets_[f].vertex[(k + 1) % 3]}) {
          fan_sets.Unite(CornerOf(f, v), CornerOf(static_cast<size_t>(partner), v));
        }
      }
    }
    struct Fan {
      int32_t point;
      uint32_t corner;
    };
    std::vector<Fan> fans;
    for (uint32_t corner = 0; corner < num_corners; ++corner) {
      if (fan_sets.Find(corner) == corner) fans.push_back({VertexAt(corner), corner});
    }
    std::sort(fans.begin(), fans.end(), [](const Fan& a, const Fan& b) {
      return std::tie(a.point, a.corner) < std::tie(b.point, b.corner);
    });
    corner_vertex_.resize(num_corners);
    for (size_t i = 0; i < fans.size(); ++i) {
      const int32_t point = fans[i].point;
      result_.num_split_vertices += (i > 0 && result_.vertex_point.back() == point);
      result_.vertex_point.push_back(point);
      result_.mesh.vertices.push_back(complex_.points[point].cast<double>());
      corner_vertex_[fans[i].corner] = static_cast<int32_t>(i);
    }
    for (uint32_t corner = 0; corner < num_corners; ++corner) {
      corner_vertex_[corner] = corner_vertex_[fan_sets.Find(corner)];
    }
  }
  int32_t VertexAt(size_t corner) const { return facets_[corner / 3].vertex[corner % 3]; }

  void WriteMesh() {
    for (size_t f = 0; f < facets_.size(); ++f) {
      result_.mesh.faces.emplace_back(corner_vertex_[3 * f], corner_vertex_[3 * f + 1],
                                      corner_vertex_[3 * f + 2]);
    }
  }

  uint64_t EdgeKey(size_t f, int k) const {
    const Eigen::Vector3i& face = result_.mesh.faces[f];
    const auto a = static_cast<uint64_t>(face[k]), b = static_cast<uint64_t>(face[(k + 1) % 3]);
    return std::min(a, b) << 32 | std::max(a, b);
  }

  std::vector<uint64_t> EdgesOfManyFaces() const {
    std::vector<uint64_t> keys;
    keys.reserve(3 * facets_.size());
    for (size_t f = 0; f < facets_.size(); ++f) {
      for (int k = 0; k < 3; ++k) keys.push_back(EdgeKey(f, k));
    }
    std::sort(keys.begin(), keys.end());
    std::vector<uint64_t> result;
    for (size_t i = 2; i < keys.size(); ++i) {
      if (keys[i] == keys[i - 2] && (result.empty() || result.back() != keys[i])) {
        result.push_back(keys[i]);
      }
    }
    return result;
  }

  // Edges of which both ends are in one fan each, but which still join more than one pair of
  // facets.
  void SplitSharedEdges() {
    struct HalfEdge {
      int32_t low, high;
      size_t facet, pair;  // pair: the lower facet of the two that are joined here
      int k;
    };
    const std::vector<uint64_t> shared_edges = EdgesOfManyFaces();
    std::vector<HalfEdge> edges;
    for (size_t f = 0; f < facets_.size() && !shared_edges.empty(); ++f) {
      for (int k = 0; k < 3; ++k) {
        const uint64_t key = EdgeKey(f, k);
        if (!std::binary_search(shared_edges.begin(), shared_edges.end(), key)) continue;
        const int32_t partner = facets_[f].partner[k];
        const size_t pair = partner < 0 ? f : std::min(f, static_cast<size_t>(partner));
        edges.push_back(
            {static_cast<int32_t>(key >> 32), static_cast<int32_t>(key & 0xFFFFFFFFu), f, pair, k});
      }
    }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
      return std::tie(a.low, a.high, a.pair, a.facet) < std::tie(b.low, b.high, b.pair, b.facet);
    });
    std::vector<std::array<int32_t, 3>>
        middles;  // by entry: middle vertex on edge k of a facet, or -1
    std::unordered_map<size_t, size_t> entry_of;
    std::vector<size_t> touched;
    for (size_t i = 1; i < edges.size(); ++i) {
      const HalfEdge &e = edges[i], &before = edges[i - 1];
      if (e.low != before.low || e.high != before.high) continue;
      const bool same_pair = e.pair == before.pair;
      const auto known = entry_of.find(before.facet);
      const int32_t shared = known == entry_of.end() ? -1 : middles[known->second][before.k];
      if (same_pair && shared < 0) continue;  // the first pair keeps the edge
      const int32_t middle = same_pair ? shared : AddMiddle(e.low, e.high, e.facet, e.k);
      const auto [it, is_new] = entry_of.try_emplace(e.facet, middles.size());
      if (is_new) {
        middles.push_back({-1, -1, -1});
        touched.push_back(e.facet);
      }
      middles[it->second][e.k] = middle;
    }
    for (const size_t f : touched) SplitFacet(f, middles[entry_of[f]]);
  }

  // A little inside of the full space between facet f and its partner across its edge k, so that
  // what rounding does to it does not take it through the other pairs at the edge.
  int32_t AddMiddle(int32_t a, int32_t b, size_t f, int k) {
    constexpr double kInset = 0.01;  // of the shortest edge around
    const auto& x = result_.mesh.vertices;
    const Eigen::Vector3d middle = 0.5 * (x[a] + x[b]);
    Eigen::Vector3d outward = UnitNormal(f);
    double shortest = ShortestEdge(f);
    if (const int32_t other = facets_[f].partner[k]; other >= 0) {
      outward += UnitNormal(static_cast<size_t>(other));
      shortest = std::min(shortest, ShortestEdge(static_cast<size_t>(other)));
    }
    result_.mesh.vertices.push_back(middle - kInset * shortest * outward.normalized());
    result_.vertex_point.push_back(-1);
    ++result_.num_split_vertices;
    return static_cast<int32_t>(result_.mesh.vertices.size() - 1);
  }

  double ShortestEdge(size_t f) const {
    const Eigen::Vector3i& face = result_.mesh.faces[f];
    const auto& x = result_.mesh.vertices;
    return std::sqrt(
        std::min({(x[face[1]] - x[face[0]]).squaredNorm(), (x[face[2]] - x[face[1]]).squaredNorm(),
                  (x[face[0]] - x[face[2]]).squaredNorm()}));
  }

  // Zero of a face without area.
  Eigen::Vector3d UnitNormal(size_t f) const {
    const Eigen::Vector3i& face = result_.mesh.faces[f];
    const auto& x = result_.mesh.vertices;
    return (x[face[1]] - x[face[0]]).cross(x[face[2]] - x[face[0]]).normalized();
  }

  // Replaces a face by a fan around its centroid-free polygon: corners with the middles between
  // them.
  void SplitFacet(size_t f, const std::array<int32_t, 3>& middle) {
    const Eigen::Vector3i face = result_.mesh.faces[f];
    std::vector<int> polygon;
    int apex = 0;
    for (int k = 0; k < 3; ++k) {
      polygon.push_back(face[k]);
      if (middle[k] < 0) continue;
      apex = static_cast<int>(polygon.size());
      polygon.push_back(middle[k]);
    }
    std::rotate(polygon.begin(), polygon.begin() + apex, polygon.end());
    // From a middle: no triangle has all its corners on one side of the old face.
    if (polygon.size() == 6) {
      // a m0 b m1 c m2, starting at a middle: corner cut-offs and the inner triangle
      const auto& p = polygon;
      result_.mesh.faces[f] = {p[0], p[2], p[4]};
      for (int k = 0; k < 6; k += 2)
        result_.mesh.faces.emplace_back(p[k], p[k + 1], p[(k + 2) % 6]);
      return;
    }
    result_.mesh.faces[f] = {polygon[0], polygon[1], polygon[2]};
    for (size_t k = 2; k + 1 < polygon.size(); ++k) {
      result_.mesh.faces.emplace_back(polygon[0], polygon[k], polygon[k + 1]);
    }
  }

  Tetrahedralization& complex_;
  std::vector<Facet> facets_;
  std::vector<int32_t> corner_vertex_;
  ExtractedSurface result_;
};

}  // namespace

ExtractedSurface ExtractSurface(Tetrahedralization complex) { return Extractor(&complex).Run(); }

}  // namespace lsmvs
