#include "lsmvs/merging/overlap/input_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr double kMaxMisorientedShare = 1e-3;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

bool IsProper(const TriangleMesh& mesh, size_t f) {
  const Eigen::Vector3i& face = mesh.faces[f];
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return false;
  return FaceNormalTimesTwiceArea(mesh, f).squaredNorm() > 0;
}

// Of faces with the same corners the first stays.
size_t DropDuplicates(TriangleMesh* mesh) {
  // Faces on one another share all their edges.
  std::vector<int32_t> suspects;
  ForEdges(SortedHalfEdges(mesh->faces, mesh->vertices.size()), [&](const HalfEdge* begin,
                                                                    const HalfEdge* end) {
    if (end - begin < 2) return;
    for (const HalfEdge* a = begin; a != end; ++a) {
      for (const HalfEdge* b = begin; b != a; ++b) {
        const Eigen::Vector3i &x = mesh->faces[Index(a->face)], &y = mesh->faces[Index(b->face)];
        const int apex = x[(a->corner + 2) % 3];
        if (apex == y[(b->corner + 2) % 3]) {
          suspects.push_back(std::max(a->face, b->face));
        }
      }
    }
  });
  if (suspects.empty()) return 0;
  std::vector<uint8_t> is_duplicate(mesh->faces.size(), 0);
  for (const int32_t f : suspects) is_duplicate[Index(f)] = 1;
  return FilterFaces(mesh, [&](size_t f) { return !is_duplicate[f]; });
}

struct EdgeFaults {
  size_t num_edges = 0, num_misoriented = 0, num_crowded = 0;
  std::vector<int32_t> misoriented_faces;  // one of each pair
};

EdgeFaults FindEdgeFaults(const TriangleMesh& mesh) {
  EdgeFaults faults;
  ForEdges(SortedHalfEdges(mesh.faces, mesh.vertices.size()),
           [&](const HalfEdge* begin, const HalfEdge* end) {
             ++faults.num_edges;
             faults.num_crowded += end - begin > 2;
             if (end - begin != 2) return;
             const auto start = [&](const HalfEdge& side) {
               return mesh.faces[Index(side.face)][side.corner];
             };
             if (start(begin[0]) != start(begin[1])) return;
             ++faults.num_misoriented;
             faults.misoriented_faces.push_back(begin[1].face);
           });
  return faults;
}

}  // namespace

RepairCounters RepairInput(const std::string& name, SourcedMesh* sourced) {
  TriangleMesh& mesh = sourced->mesh;
  if (mesh.faces.empty()) throw InputError(name, "has no faces", "give a mesh");
  RepairCounters counters;
  counters.num_dropped_faces = FilterFaces(&mesh, [&](size_t f) { return IsProper(mesh, f); });
  counters.num_dropped_faces += DropDuplicates(&mesh);
  if (mesh.faces.empty()) throw InputError(name, "has no faces with an area", "give a mesh");
  const EdgeFaults faults = FindEdgeFaults(mesh);
  if (static_cast<double>(faults.num_misoriented) >
      kMaxMisorientedShare * static_cast<double>(faults.num_edges)) {
    throw InputError(name,
                     fmt::format("{} of {} edges join faces that are not oriented alike",
                                 faults.num_misoriented, faults.num_edges),
                     "orient its faces coherently and outward, as MeshLab's 'Re-Orient all faces "
                     "coherently' does");
  }
  if (faults.num_misoriented > 0) {
    std::vector<uint8_t> is_wrong(mesh.faces.size(), 0);
    for (const int32_t f : faults.misoriented_faces) is_wrong[Index(f)] = 1;
    counters.num_dropped_faces += FilterFaces(&mesh, [&](size_t f) { return !is_wrong[f]; });
  }
  for (const int source : SplitNonManifoldVertices(&mesh)) {
    sourced->sources.push_back(VertexSource(sourced->sources[Index(source)]));
    sourced->is_changed.push_back(0);
    ++counters.num_split_vertices;
  }
  return counters;
}

}  // namespace lsmvs
