#include "lsmvs/merging/zip/zipper.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "lsmvs/merging/overlap/mesh_band.h"
#include "lsmvs/merging/overlap/surface_index.h"
#include "lsmvs/merging/zip/polygon_filling.h"
#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

// In edge lengths: how far apart vertices of two rims may be joined, and how far an old border lies
// that takes part.
constexpr double kMaxBridge = 5, kMaxOldBorder = 3;
constexpr double kMinNormalCosine = 0.2;
// Vertices of a rim between two bridges, about.
constexpr size_t kBridgeSpacing = 4;
constexpr size_t kMaxPolygon = 48, kMaxLoop = 160;
// Edge lengths across gaps between a rim and an old border that are filled where they are closed.
constexpr double kMaxGap = 25;
constexpr double kNoLimit = 1e300;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

class Zipper {
 public:
  explicit Zipper(const ZipProblem& problem)
      : problem_(problem), mesh_(*problem.mesh), next_(mesh_.vertices.size(), -1) {}

  ZipResult Run() {
    FindBorder();
    MarkRims();
    CollectEdges();
    TraceLoops();
    PairVertices();
    JoinLoops();
    FillLoops();
    CloseEnds();
    FindOpenEdges();
    return std::move(result_);
  }

 private:
  struct Bridge {
    size_t i, j;    // positions on the loop of the first surface and, counted backwards, the second
    double length;  // in edge lengths
  };

  const Eigen::Vector3d& At(int32_t v) const { return mesh_.vertices[Index(v)]; }
  static bool Holds(const std::vector<uint64_t>& keys, uint64_t key) {
    return std::binary_search(keys.begin(), keys.end(), key);
  }

  void FindBorder() {
    const std::vector<HalfEdge> sides = SortedHalfEdges(mesh_.faces, mesh_.vertices.size());
    is_rim_.assign(mesh_.vertices.size(), 0);
    ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
      if (end - begin != 1) return;
      const Eigen::Vector3i& face = mesh_.faces[Index(begin->face)];
      const int from = face[begin->corner], to = face[(begin->corner + 1) % 3];
      next_[Index(to)] = from;
      const uint64_t key = EdgeKey(from, to);
      if (Holds(problem_.cut_edges, key) || Holds(problem_.old_border, key)) return;
      is_rim_[Index(from)] = is_rim_[Index(to)] = 1;
      rim_edges_[problem_.side[Index(from)]].emplace_back(from, to, to);
    });
  }

  // Old borders that lie by the rim of the other surface take part.
  void MarkRims() {
    std::vector<uint8_t> on_cut(mesh_.vertices.size(), 0);
    for (const uint64_t key : problem_.cut_edges) {
      on_cut[key >> 32] = on_cut[key & 0xFFFFFFFFu] = 1;
    }
    const std::array<SurfaceIndex, 2> rims = {SurfaceIndex(mesh_.vertices, rim_edges_[0]),
                                              SurfaceIndex(mesh_.vertices, rim_edges_[1])};
    std::array<double, 2> longest = {0, 0};  // edge lengths at the rims
    for (size_t k = 0; k < 2; ++k) {
      for (const Eigen::Vector3i& edge : rim_edges_[k]) {
        longest[k] = std::max(longest[k], problem_.edge_length[Index(edge[0])]);
      }
    }
    std::vector<int32_t> added;
    for (size_t v = 0; v < next_.size(); ++v) {
      if (next_[v] < 0 || is_rim_[v] || on_cut[v]) continue;
      // The rim keeps away from the border by edge lengths of the coarser surface.
      const size_t other = 1 - problem_.side[v];
      const double own = problem_.edge_length[v];
      const auto hit =
          rims[other].Closest(mesh_.vertices[v], kMaxOldBorder * std::max(own, longest[other]));
      if (hit.face < 0) continue;
      const double there = problem_.edge_length[Index(rim_edges_[other][Index(hit.face)][0])];
      if (hit.distance < kMaxOldBorder * std::max(own, there)) {
        added.push_back(static_cast<int32_t>(v));
      }
    }
    for (const int32_t v : added) is_rim_[Index(v)] = 1;
  }

  // Edges of the mesh between vertices of the border: they must not be made again.
  void CollectEdges() {
    for (const Eigen::Vector3i& face : mesh_.faces) {
      for (int k = 0; k < 3; ++k) {
        const int a = face[k], b = face[(k + 1) % 3];
        if (next_[Index(a)] >= 0 && next_[Index(b)] >= 0) edges_.insert(EdgeKey(a, b));
      }
    }
  }

  void TraceLoops() {
    loop_of_.assign(next_.size(), -1);
    place_.assign(next_.size(), 0);
    for (size_t v = 0; v < next_.size(); ++v) {
      if (next_[v] < 0 || loop_of_[v] >= 0) continue;
      std::vector<int32_t> loop;
      for (int32_t w = static_cast<int32_t>(v); w >= 0 && loop_of_[Index(w)] < 0;
           w = next_[Index(w)]) {
        loop_of_[Index(w)] = static_cast<int32_t>(loops_.size());
        place_[Index(w)] = loop.size();
        loop.push_back(w);
      }
      loops_.push_back(std::move(loop));
    }
  }

  void PairVertices() {
    std::array<std::vector<Eigen::Vector3i>, 2> points;
    for (size_t v = 0; v < is_rim_.size(); ++v) {
      const int32_t i = static_cast<int32_t>(v);
      if (is_rim_[v] && loop_of_[v] >= 0) points[problem_.side[v]].emplace_back(i, i, i);
    }
    const std::array<SurfaceIndex, 2> indices = {SurfaceIndex(mesh_.vertices, points[0]),
                                                 SurfaceIndex(mesh_.vertices, points[1])};
    nearest_.assign(is_rim_.size(), -1);
    for (int side = 0; side < 2; ++side) {
      const auto& others = points[Index(1 - side)];
      for (const Eigen::Vector3i& point : points[Index(side)]) {
        const size_t v = Index(point[0]);
        const auto accept = [&](int32_t k) {
          const size_t w = Index(others[Index(k)][0]);
          return problem_.normal[v].dot(problem_.normal[w]) > kMinNormalCosine;
        };
        const double reach = kMaxBridge * problem_.edge_length[v];
        const auto hit = indices[Index(1 - side)].Closest(mesh_.vertices[v], reach, accept);
        if (hit.face >= 0) nearest_[v] = others[Index(hit.face)][0];
      }
    }
  }

  double BridgeLength(int32_t a, int32_t b) const {
    const double edge = std::max(problem_.edge_length[Index(a)], problem_.edge_length[Index(b)]);
    return (At(a) - At(b)).norm() / edge;
  }

  // Most bridges first, where a rim lies by several.
  void JoinLoops() {
    // Pairs of vertices that are nearest to each other, by their loops.
    std::map<std::pair<int32_t, int32_t>, std::vector<std::pair<int32_t, int32_t>>> pairs;
    for (size_t v = 0; v < nearest_.size(); ++v) {
      const int32_t w = nearest_[v];
      if (w < 0 || problem_.side[v] != 0 || nearest_[Index(w)] != static_cast<int32_t>(v)) continue;
      pairs[{loop_of_[v], loop_of_[Index(w)]}].emplace_back(static_cast<int32_t>(v), w);
    }
    AddEnds(&pairs);
    std::vector<std::pair<int32_t, int32_t>> order;
    for (const auto& [loops, list] : pairs) order.push_back(loops);
    std::stable_sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return pairs[a].size() > pairs[b].size();
    });
    for (const auto& loops : order) {
      JoinTwo(loops_[Index(loops.first)], loops_[Index(loops.second)], pairs[loops]);
    }
  }

  // Where a rim ends at an old border, there is no pair beyond: its last vertex takes the nearest.
  void AddEnds(std::map<std::pair<int32_t, int32_t>, std::vector<std::pair<int32_t, int32_t>>>*
                   pairs) const {
    std::vector<uint8_t> is_end(is_rim_.size(), 0);
    for (size_t v = 0; v < is_end.size(); ++v) {
      const int32_t w = next_[v];
      if (w < 0 || is_rim_[v] == is_rim_[Index(w)]) continue;
      is_end[is_rim_[v] ? v : Index(w)] = 1;
    }
    for (size_t v = 0; v < is_end.size(); ++v) {
      const int32_t w = nearest_[v];
      if (!is_end[v] || w < 0 || nearest_[Index(w)] == static_cast<int32_t>(v)) continue;
      const auto pair = problem_.side[v] == 0 ? std::pair(static_cast<int32_t>(v), w)
                                              : std::pair(w, static_cast<int32_t>(v));
      auto found = pairs->find({loop_of_[Index(pair.first)], loop_of_[Index(pair.second)]});
      if (found != pairs->end()) found->second.push_back(pair);
    }
  }

  // Along the first loop, and backwards along the second, from the shortest pair on.
  void JoinTwo(const std::vector<int32_t>& first, const std::vector<int32_t>& second,
               const std::vector<std::pair<int32_t, int32_t>>& pairs) {
    const auto shortest = std::min_element(pairs.begin(), pairs.end(), [&](auto& a, auto& b) {
      return BridgeLength(a.first, a.second) < BridgeLength(b.first, b.second);
    });
    const size_t i0 = place_[Index(shortest->first)], j0 = place_[Index(shortest->second)];
    std::vector<Bridge> bridges;
    for (const auto& [a, b] : pairs) {
      bridges.push_back({(place_[Index(a)] + first.size() - i0) % first.size(),
                         (j0 + second.size() - place_[Index(b)]) % second.size(),
                         BridgeLength(a, b)});
    }
    std::sort(bridges.begin(), bridges.end(), [](const Bridge& a, const Bridge& b) {
      return std::tie(a.i, a.j) < std::tie(b.i, b.j);
    });
    bridges = Thinned(LongestRisingChain(bridges));
    // Back to the first one, all the way round.
    bridges.push_back({first.size(), second.size(), bridges.front().length});
    const auto first_at = [&](size_t i) { return first[(i0 + i) % first.size()]; };
    const auto second_at = [&](size_t j) {
      return second[(j0 + 2 * second.size() - j) % second.size()];
    };
    for (size_t k = 0; k + 1 < bridges.size(); ++k) {
      FillBetween(first_at, second_at, bridges[k], bridges[k + 1]);
    }
  }

  // Bridges that follow each other on both loops, as many as possible. The first one is (0, 0).
  static std::vector<Bridge> LongestRisingChain(const std::vector<Bridge>& bridges) {
    std::vector<size_t> tails;  // of chains of each length, the one that ends lowest
    std::vector<int64_t> before(bridges.size(), -1);
    for (size_t k = 0; k < bridges.size(); ++k) {
      const auto at = std::lower_bound(tails.begin(), tails.end(), bridges[k].j,
                                       [&](size_t t, size_t j) { return bridges[t].j < j; });
      if (at != tails.begin()) before[k] = static_cast<int64_t>(*(at - 1));
      if (at == tails.end()) {
        tails.push_back(k);
      } else {
        *at = k;
      }
    }
    std::vector<Bridge> chain;
    for (int64_t k = static_cast<int64_t>(tails.back()); k >= 0;
         k = before[static_cast<size_t>(k)]) {
      chain.push_back(bridges[static_cast<size_t>(k)]);
    }
    std::reverse(chain.begin(), chain.end());
    return chain;
  }

  // One bridge in about kBridgeSpacing vertices: the shortest ones.
  static std::vector<Bridge> Thinned(const std::vector<Bridge>& bridges) {
    std::vector<Bridge> thinned = {bridges.front()};
    for (size_t k = 1; k < bridges.size();) {
      const auto advance = [&](size_t m) {
        return std::max(bridges[m].i - thinned.back().i, bridges[m].j - thinned.back().j);
      };
      size_t best = k;
      for (size_t m = k; m < bridges.size() && advance(m) <= 2 * kBridgeSpacing; ++m) {
        const bool is_far = advance(m) >= kBridgeSpacing;
        if (advance(best) < kBridgeSpacing ? is_far || m > best
                                           : is_far && bridges[m].length < bridges[best].length) {
          best = m;
        }
      }
      thinned.push_back(bridges[best]);
      k = best + 1;
    }
    return thinned;
  }

  template <class FirstAt, class SecondAt>
  void FillBetween(const FirstAt& first_at, const SecondAt& second_at, const Bridge& from,
                   const Bridge& to) {
    std::vector<int32_t> polygon;
    for (size_t i = from.i; i <= to.i; ++i) polygon.push_back(first_at(i));
    for (size_t j = to.j + 1; j-- > from.j;) polygon.push_back(second_at(j));
    if (!std::all_of(polygon.begin(), polygon.end(),
                     [&](int32_t v) { return is_rim_[Index(v)]; })) {
      return;
    }
    if (polygon.size() <= kMaxPolygon) {
      Fill(polygon);
      return;
    }
    const Bridge middle = MiddleBridge(first_at, second_at, from, to);
    if (middle.length > kMaxBridge) return;
    FillBetween(first_at, second_at, from, middle);
    FillBetween(first_at, second_at, middle, to);
  }

  // The shortest bridge near the middle of a long polygon.
  template <class FirstAt, class SecondAt>
  Bridge MiddleBridge(const FirstAt& first_at, const SecondAt& second_at, const Bridge& from,
                      const Bridge& to) const {
    const auto inner = [](size_t begin, size_t end) {
      const size_t quarter = (end - begin) / 4;
      return std::pair(begin + quarter, end - quarter);
    };
    Bridge best{from.i, from.j, 1e300};
    const auto [i_begin, i_end] = inner(from.i, to.i);
    const auto [j_begin, j_end] = inner(from.j, to.j);
    for (size_t i = i_begin; i <= i_end; ++i) {
      for (size_t j = j_begin; j <= j_end; ++j) {
        const bool is_new = (i > from.i || j > from.j) && (i < to.i || j < to.j);
        const double length = BridgeLength(first_at(i), second_at(j));
        if (is_new && length < best.length) best = {i, j, length};
      }
    }
    return best;
  }

  static uint64_t SideKey(int32_t from, int32_t to) {
    return static_cast<uint64_t>(from) << 32 | static_cast<uint64_t>(to);
  }

  // Nothing if a new edge would be longer than `max_length` edge lengths.
  bool Fill(const std::vector<int32_t>& polygon, double max_length = kNoLimit) {
    const auto may_join = [&](int32_t a, int32_t b) { return !edges_.contains(EdgeKey(a, b)); };
    std::vector<int32_t> sorted = polygon;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return false;
    // Each edge of a rim gets one face; bridges are new, or sides of a polygon that is filled.
    const auto next_of = [&](size_t i) { return polygon[(i + 1) % polygon.size()]; };
    for (size_t i = 0; i < polygon.size(); ++i) {
      if (used_sides_.contains(SideKey(polygon[i], next_of(i)))) return false;
    }
    const std::vector<Eigen::Vector3i> faces =
        FillPolygon(mesh_.vertices, problem_.normal, polygon, may_join);
    for (const Eigen::Vector3i& face : faces) {
      for (int k = 0; k < 3; ++k) {
        if (BridgeLength(face[k], face[(k + 1) % 3]) > max_length) return false;
      }
    }
    for (const Eigen::Vector3i& face : faces) {
      for (int k = 0; k < 3; ++k) {
        edges_.insert(EdgeKey(face[k], face[(k + 1) % 3]));
        used_sides_.insert(SideKey(face[k], face[(k + 1) % 3]));
      }
    }
    result_.faces.insert(result_.faces.end(), faces.begin(), faces.end());
    return !faces.empty();
  }

  // An edge of the border, as a new face at it runs.
  struct HoleEdge {
    int32_t from, to, face;
  };

  // Border of the mesh with the new faces, by `from`.
  std::vector<HoleEdge> BorderNow() {
    faces_now_ = mesh_.faces;
    faces_now_.insert(faces_now_.end(), result_.faces.begin(), result_.faces.end());
    std::vector<HoleEdge> edges;
    ForEdges(SortedHalfEdges(faces_now_, mesh_.vertices.size()),
             [&](const HalfEdge* begin, const HalfEdge* end) {
               if (end - begin != 1) return;
               const Eigen::Vector3i& face = faces_now_[Index(begin->face)];
               edges.push_back({face[(begin->corner + 1) % 3], face[begin->corner], begin->face});
             });
    std::sort(edges.begin(), edges.end(), [](const HoleEdge& a, const HoleEdge& b) {
      return std::tie(a.from, a.to) < std::tie(b.from, b.to);
    });
    return edges;
  }

  // The fans of the faces at a vertex, by face.
  std::map<int32_t, uint32_t> FansAt(int32_t v, const std::vector<int32_t>& faces) const {
    DisjointSets sets(faces.size());
    std::map<int32_t, uint32_t> face_at;  // by the other vertex of an edge at v
    for (uint32_t i = 0; i < faces.size(); ++i) {
      for (const int32_t w : faces_now_[Index(faces[i])]) {
        if (w == v) continue;
        const auto [it, is_new] = face_at.emplace(w, i);
        if (!is_new) sets.Unite(i, it->second);
      }
    }
    std::map<int32_t, uint32_t> fans;
    for (uint32_t i = 0; i < faces.size(); ++i) fans[faces[i]] = sets.Find(i);
    return fans;
  }

  // Successor of each edge of the border around its hole. Where several holes meet at a vertex, an
  // edge of one fan of faces is followed by one of the next fan.
  std::vector<size_t> Successors(const std::vector<HoleEdge>& edges) const {
    const auto first_from = [&](int32_t v) {
      const auto at = std::lower_bound(edges.begin(), edges.end(), v,
                                       [](const HoleEdge& e, int32_t w) { return e.from < w; });
      return static_cast<size_t>(at - edges.begin());
    };
    std::map<int32_t, std::vector<int32_t>> faces_at;  // of vertices between several holes
    for (size_t e = 0; e + 1 < edges.size(); ++e) {
      if (edges[e].from == edges[e + 1].from) faces_at[edges[e].from];
    }
    for (size_t f = 0; f < faces_now_.size() && !faces_at.empty(); ++f) {
      for (const int32_t v : faces_now_[f]) {
        const auto found = faces_at.find(v);
        if (found != faces_at.end()) found->second.push_back(static_cast<int32_t>(f));
      }
    }
    std::vector<size_t> successors(edges.size());
    for (size_t e = 0; e < edges.size(); ++e) successors[e] = first_from(edges[e].to);
    for (const auto& [v, faces] : faces_at) {
      const std::map<int32_t, uint32_t> fans = FansAt(v, faces);
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

  bool IsOldOrCut(int32_t a, int32_t b) const {
    const uint64_t key = EdgeKey(a, b);
    return Holds(problem_.old_border, key) || Holds(problem_.cut_edges, key);
  }

  void FillLoops() {
    const std::vector<HoleEdge> edges = BorderNow();
    const std::vector<size_t> successors = Successors(edges);
    std::vector<uint8_t> is_done(edges.size(), 0);
    for (size_t start = 0; start < edges.size(); ++start) {
      if (is_done[start]) continue;
      std::vector<int32_t> loop;
      bool is_new = false, has_cut = false, all_rim = true;
      for (size_t e = start; e < edges.size() && !is_done[e]; e = successors[e]) {
        is_done[e] = 1;
        const auto [from, to, face] = edges[e];
        loop.push_back(from);
        all_rim &= is_rim_[Index(from)] != 0;
        has_cut |= Holds(problem_.cut_edges, EdgeKey(from, to));
        is_new |= !IsOldOrCut(from, to) && !IsBridge(from, to);
      }
      if (!is_new || has_cut || loop.size() < 3 || loop.size() > kMaxLoop) continue;
      Fill(loop, all_rim ? kNoLimit : kMaxGap);
    }
  }

  bool IsNewRim(int32_t from, int32_t to) const {
    return problem_.side[Index(from)] == problem_.side[Index(to)] && !IsOldOrCut(from, to);
  }
  bool IsBridge(int32_t from, int32_t to) const {
    return problem_.side[Index(from)] != problem_.side[Index(to)];
  }

  // Where a seam ends at a border, edges of a rim may go on beyond the last bridge: next to a
  // bridge a triangle is added with the edge before or after it, whichever makes the shorter next
  // bridge, as long as one of both is of a rim.
  void CloseEnds() {
    std::vector<int32_t> next(mesh_.vertices.size(), -1), previous(next);
    std::vector<int32_t> waiting;
    for (const auto& [from, to, face] : BorderNow()) {
      next[Index(from)] = to;
      previous[Index(to)] = from;
      if (IsBridge(from, to)) waiting.push_back(from);
    }
    while (!waiting.empty()) {
      const int32_t a = waiting.back(), b = next[Index(a)];
      waiting.pop_back();
      if (b < 0 || !IsBridge(a, b)) continue;
      const int32_t before = previous[Index(a)], after = next[Index(b)];
      if (before < 0 || after < 0 || before == b || after == a) continue;
      if (!IsNewRim(before, a) && !IsNewRim(b, after)) continue;
      const auto take_before = [&] {
        if (!MayBeUsed(before, a) || !AddTriangle(before, a, b)) return false;
        next[Index(before)] = b;
        previous[Index(b)] = before;
        next[Index(a)] = previous[Index(a)] = -1;
        waiting.push_back(before);
        return true;
      };
      const auto take_after = [&] {
        if (!MayBeUsed(b, after) || !AddTriangle(a, b, after)) return false;
        next[Index(a)] = after;
        previous[Index(after)] = a;
        next[Index(b)] = previous[Index(b)] = -1;
        waiting.push_back(a);
        return true;
      };
      if (BridgeLength(before, b) <= BridgeLength(a, after)) {
        if (!take_before()) take_after();
      } else if (!take_after()) {
        take_before();
      }
    }
  }

  bool MayBeUsed(int32_t from, int32_t to) const {
    return !IsBridge(from, to) && !Holds(problem_.cut_edges, EdgeKey(from, to));
  }

  // Unless it would be turned away from the surface, too long, or repeat an edge.
  bool AddTriangle(int32_t a, int32_t b, int32_t c) {
    const Eigen::Vector3d normal = (At(b) - At(a)).cross(At(c) - At(a));
    const Eigen::Vector3d expected =
        problem_.normal[Index(a)] + problem_.normal[Index(b)] + problem_.normal[Index(c)];
    if (normal.dot(expected) <= 0.3 * normal.norm() * expected.norm()) return false;
    if (BridgeLength(a, c) > kMaxBridge || edges_.contains(EdgeKey(a, c))) return false;
    edges_.insert(EdgeKey(a, c));
    result_.faces.emplace_back(a, b, c);
    return true;
  }

  void FindOpenEdges() {
    for (const auto& [from, to, face] : BorderNow()) {
      // Where a seam ends at the borders of both surfaces, a bridge closes it.
      if (IsBridge(from, to) || IsOldOrCut(from, to)) continue;
      result_.open_edges.push_back({to, from});
    }
  }

  const ZipProblem& problem_;
  const TriangleMesh& mesh_;
  std::vector<int32_t> next_;  // along the border, as new faces run; -1 inside
  std::vector<uint8_t> is_rim_;
  std::array<std::vector<Eigen::Vector3i>, 2> rim_edges_;
  std::unordered_set<uint64_t> edges_;       // that are there, between vertices of the border
  std::unordered_set<uint64_t> used_sides_;  // of new faces, in their direction
  std::vector<std::vector<int32_t>> loops_;
  std::vector<int32_t> loop_of_;
  std::vector<size_t> place_;
  std::vector<int32_t> nearest_;            // vertex of the other rim
  std::vector<Eigen::Vector3i> faces_now_;  // of the mesh and new
  ZipResult result_;
};

}  // namespace

ZipResult ZipRims(const ZipProblem& problem) { return Zipper(problem).Run(); }

}  // namespace lsmvs
