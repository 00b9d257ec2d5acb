#include "lsmvs/merging/zip/refilling.h"

#include <algorithm>
#include <map>
#include <unordered_set>
#include <utility>

#include "lsmvs/merging/overlap/mesh_band.h"
#include "lsmvs/merging/zip/polygon_filling.h"
#include "lsmvs/mesh/by_vertex.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

constexpr int kMaxRings = 3;
constexpr size_t kMaxPolygon = 200, kMaxPatchFaces = 1500;

using Pairs = std::vector<std::pair<int32_t, int32_t>>;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

class Refiller {
 public:
  Refiller(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> normals,
           const std::vector<uint8_t>& is_free, const std::vector<uint8_t>& is_active,
           const RunContext& context)
      : num_old_(mesh.faces.size()),
        normals_(normals),
        is_free_(is_free),
        is_active_(is_active),
        is_dropped_(num_old_, 0),
        context_(context) {
    mesh_.vertices = mesh.vertices;
    mesh_.faces = mesh.faces;
  }

  Refilling Run() {
    Pairs crossings = Crossings(is_active_);
    for (int num_rings = 0; num_rings <= kMaxRings && !crossings.empty(); ++num_rings) {
      if (Refill(crossings, num_rings)) crossings = Crossings(is_active_);
    }
    Refilling result;
    for (size_t f = num_old_; f < mesh_.faces.size(); ++f) {
      if (!is_dropped_[f]) result.faces.push_back(mesh_.faces[f]);
    }
    is_dropped_.resize(num_old_);
    result.is_dropped = std::move(is_dropped_);
    return result;
  }

 private:
  // Faces that are replaced together.
  struct Patch {
    std::vector<int32_t> faces;
    std::vector<Eigen::Vector3i> filling;
  };

  // Of faces that were not dropped.
  Pairs Crossings(const std::vector<uint8_t>& is_active) const {
    std::vector<Eigen::Vector3i> faces;
    std::vector<int32_t> number;
    std::vector<uint8_t> active;
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (is_dropped_[f]) continue;
      faces.push_back(mesh_.faces[f]);
      number.push_back(static_cast<int32_t>(f));
      active.push_back(is_active[f]);
    }
    Pairs pairs = FaceGrid(mesh_.vertices, faces).CrossingPairs(active, context_);
    for (auto& [a, b] : pairs) {
      a = number[Index(a)];
      b = number[Index(b)];
    }
    return pairs;
  }

  // Of those that were not dropped.
  template <class Visit>
  void ForFacesAt(int32_t v, const Visit& visit) const {
    for (const uint32_t corner : corners_of_.Of(Index(v))) {
      if (!is_dropped_[corner / 3]) visit(static_cast<int32_t>(corner / 3));
    }
  }

  // Whether anything has changed.
  bool Refill(const Pairs& crossings, int num_rings) {
    corners_of_ = CornersByVertex(mesh_.vertices.size(), mesh_.faces);
    std::vector<Patch> patches = MakePatches(crossings, num_rings);
    std::erase_if(patches, [&](Patch& patch) { return !FillPatch(&patch); });
    std::vector<size_t> patch_of;  // of new faces
    const size_t first_new = mesh_.faces.size();
    for (size_t p = 0; p < patches.size(); ++p) {
      for (const int32_t f : patches[p].faces) is_dropped_[Index(f)] = 1;
      for (const Eigen::Vector3i& face : patches[p].filling) {
        mesh_.faces.push_back(face);
        is_dropped_.push_back(0);
        is_active_.push_back(1);
        patch_of.push_back(p);
      }
    }
    std::vector<uint8_t> is_new(mesh_.faces.size(), 0);
    std::fill(is_new.begin() + static_cast<std::ptrdiff_t>(first_new), is_new.end(), uint8_t{1});
    std::vector<uint8_t> fails(patches.size(), 0);
    for (const auto& pair : Crossings(is_new)) {
      for (const int32_t f : {pair.first, pair.second}) {
        if (Index(f) >= first_new) fails[patch_of[Index(f) - first_new]] = 1;
      }
    }
    for (size_t p = 0; p < patches.size(); ++p) {
      for (const int32_t f : patches[p].faces) {
        if (fails[p]) is_dropped_[Index(f)] = 0;
      }
    }
    for (size_t f = first_new; f < mesh_.faces.size(); ++f) {
      is_dropped_[f] = fails[patch_of[f - first_new]];
    }
    return std::find(fails.begin(), fails.end(), uint8_t{0}) != fails.end();
  }

  std::vector<Patch> MakePatches(const Pairs& crossings, int num_rings) const {
    std::vector<uint8_t> in_patch(mesh_.faces.size(), 0);
    std::vector<int32_t> faces;
    const auto add = [&](int32_t f) {
      if (!in_patch[Index(f)]) faces.push_back(f);
      in_patch[Index(f)] = 1;
    };
    for (const auto& [a, b] : crossings) {
      add(a);
      add(b);
    }
    for (int ring = 0; ring < num_rings; ++ring) {
      const size_t num_before = faces.size();
      for (size_t i = 0; i < num_before; ++i) {
        for (const int v : mesh_.faces[Index(faces[i])]) ForFacesAt(v, add);
      }
    }
    std::sort(faces.begin(), faces.end());
    return Components(faces, crossings);
  }

  // Faces that share a vertex or cross each other belong together.
  std::vector<Patch> Components(const std::vector<int32_t>& faces, const Pairs& crossings) const {
    DisjointSets sets(faces.size());
    const auto number_of = [&](int32_t f) {
      return static_cast<uint32_t>(std::lower_bound(faces.begin(), faces.end(), f) - faces.begin());
    };
    for (const auto& [a, b] : crossings) sets.Unite(number_of(a), number_of(b));
    std::map<int, uint32_t> face_at;  // of a vertex
    for (uint32_t i = 0; i < faces.size(); ++i) {
      for (const int v : mesh_.faces[Index(faces[i])]) {
        const auto [it, is_first] = face_at.emplace(v, i);
        if (!is_first) sets.Unite(i, it->second);
      }
    }
    std::map<uint32_t, Patch> patches;
    for (uint32_t i = 0; i < faces.size(); ++i) patches[sets.Find(i)].faces.push_back(faces[i]);
    std::vector<Patch> list;
    for (auto& [set, patch] : patches) list.push_back(std::move(patch));
    return list;
  }

  // False if there is no way.
  bool FillPatch(Patch* patch) const {
    if (patch->faces.size() > kMaxPatchFaces) return false;
    std::vector<std::vector<int32_t>> loops;
    if (!TraceLoops(patch->faces, &loops)) return false;
    const std::unordered_set<uint64_t> edges = EdgesOutside(patch->faces, loops);
    std::unordered_set<uint64_t> added;
    for (const std::vector<int32_t>& loop : loops) {
      if (loop.size() < 3 || loop.size() > kMaxPolygon) return false;
      const auto may_join = [&](int32_t a, int32_t b) {
        return (is_free_[Index(a)] || is_free_[Index(b)]) && !edges.contains(EdgeKey(a, b)) &&
               !added.contains(EdgeKey(a, b));
      };
      const std::vector<Eigen::Vector3i> filling =
          FillPolygon(mesh_.vertices, normals_, loop, may_join);
      if (filling.empty()) return false;
      for (const Eigen::Vector3i& face : filling) {
        for (int k = 0; k < 3; ++k) added.insert(EdgeKey(face[k], face[(k + 1) % 3]));
      }
      patch->filling.insert(patch->filling.end(), filling.begin(), filling.end());
    }
    return true;
  }

  // The border of a patch, along its faces. False if it touches itself.
  bool TraceLoops(const std::vector<int32_t>& faces,
                  std::vector<std::vector<int32_t>>* loops) const {
    std::map<std::pair<int, int>, int> sides;
    for (const int32_t f : faces) {
      const Eigen::Vector3i& face = mesh_.faces[Index(f)];
      for (int k = 0; k < 3; ++k) sides[{face[k], face[(k + 1) % 3]}] = 0;
    }
    std::map<int, int> next;
    for (const auto& [side, unused] : sides) {
      if (sides.contains({side.second, side.first})) continue;
      if (!next.emplace(side.first, side.second).second) return false;
    }
    while (!next.empty()) {
      std::vector<int32_t> loop;
      const int first = next.begin()->first;
      for (auto at = next.begin(); at != next.end();) {
        const int to = at->second;
        loop.push_back(at->first);
        next.erase(at);
        at = to == first ? next.end() : next.find(to);
      }
      loops->push_back(std::move(loop));
    }
    return true;
  }

  // Edges between vertices of the loops that faces outside of a patch have.
  std::unordered_set<uint64_t> EdgesOutside(const std::vector<int32_t>& faces,
                                            const std::vector<std::vector<int32_t>>& loops) const {
    std::unordered_set<uint64_t> edges;
    for (const auto& loop : loops) {
      for (const int32_t v : loop) {
        ForFacesAt(v, [&](int32_t f) {
          if (std::binary_search(faces.begin(), faces.end(), f)) return;
          const Eigen::Vector3i& face = mesh_.faces[Index(f)];
          for (int k = 0; k < 3; ++k) edges.insert(EdgeKey(face[k], face[(k + 1) % 3]));
        });
      }
    }
    return edges;
  }

  TriangleMesh mesh_;  // with the new faces behind the old ones
  size_t num_old_;
  std::span<const Eigen::Vector3d> normals_;
  const std::vector<uint8_t>& is_free_;
  std::vector<uint8_t> is_active_, is_dropped_;  // #F with the new ones
  const RunContext& context_;
  ByVertex corners_of_;  // with those of dropped faces
};

}  // namespace

Refilling RefillCrossings(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> normals,
                          const std::vector<uint8_t>& is_free,
                          const std::vector<uint8_t>& is_active, const RunContext& context) {
  return Refiller(mesh, normals, is_free, is_active, context).Run();
}

}  // namespace lsmvs
