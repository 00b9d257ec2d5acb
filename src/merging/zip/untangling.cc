#include "lsmvs/merging/zip/untangling.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "lsmvs/merging/overlap/overlap.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {

namespace {

constexpr int kMaxRounds = 4, kMaxSteps = 24, kStepsOfOneRing = 3;
constexpr double kStep = 0.6;
// Neighbours whose normals enclose more than this are folded.
constexpr double kFoldCosine = -0.7;
constexpr double kMaxRoundingPart = 1e-4;
// Edge lengths around the crossings that are worked on.
constexpr double kReach = 8;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

bool HasOne(const std::vector<uint8_t>& flags) {
  return std::any_of(flags.begin(), flags.end(), [](uint8_t flag) { return flag != 0; });
}

// A mesh, or the part of one around the crossings.
struct Tangle {
  TriangleMesh mesh;
  std::vector<uint8_t> may_move, has_moved;  // #V
  std::vector<uint8_t> is_new;               // #F
};

std::vector<uint8_t> ActiveFaces(const TriangleMesh& mesh, const std::vector<uint8_t>& is_new,
                                 const std::vector<uint8_t>& has_moved) {
  std::vector<uint8_t> is_active = is_new;
  for (size_t f = 0; f < is_active.size(); ++f) {
    for (const int v : mesh.faces[f]) is_active[f] |= has_moved[Index(v)];
  }
  return is_active;
}

struct Faults {
  std::vector<uint8_t> faces;      // #F: crossing or folded
  std::vector<int32_t> crossings;  // a vertex of each pair
};

Faults FindFaults(const TriangleMesh& mesh, const std::vector<uint8_t>& is_new,
                  const std::vector<uint8_t>& has_moved, const RunContext& context) {
  Faults faults;
  faults.faces.assign(mesh.faces.size(), 0);
  const FaceGrid grid(mesh.vertices, mesh.faces);
  for (const auto& [a, b] : grid.CrossingPairs(ActiveFaces(mesh, is_new, has_moved), context)) {
    faults.faces[Index(a)] = faults.faces[Index(b)] = 1;
    faults.crossings.push_back(mesh.faces[Index(a)][0]);
  }
  const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
  for (size_t f = 0; f < is_new.size(); ++f) {
    if (!is_new[f]) continue;
    for (const int32_t other : neighbors[f]) {
      if (other < 0) continue;
      const Eigen::Vector3d a = FaceNormalTimesTwiceArea(mesh, f),
                            b = FaceNormalTimesTwiceArea(mesh, Index(other));
      if (a.dot(b) < kFoldCosine * a.norm() * b.norm()) {
        faults.faces[f] = faults.faces[Index(other)] = 1;
      }
    }
  }
  return faults;
}

std::vector<uint8_t> Either(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  std::vector<uint8_t> either = a;
  for (size_t i = 0; i < b.size(); ++i) either[i] |= b[i];
  return either;
}

// Sets the vertices of the faces at which a flag is set.
std::vector<uint8_t> VerticesOf(const TriangleMesh& mesh, const std::vector<uint8_t>& faces) {
  std::vector<uint8_t> vertices(mesh.vertices.size(), 0);
  for (size_t f = 0; f < faces.size(); ++f) {
    for (int k = 0; k < 3 && faces[f]; ++k) vertices[Index(mesh.faces[f][k])] = 1;
  }
  return vertices;
}

void GrowByRing(const TriangleMesh& mesh, std::vector<uint8_t>* vertices) {
  const std::vector<uint8_t> before = *vertices;
  for (const Eigen::Vector3i& face : mesh.faces) {
    if (!before[Index(face[0])] && !before[Index(face[1])] && !before[Index(face[2])]) continue;
    for (const int v : face) (*vertices)[Index(v)] = 1;
  }
}

// Before and behind each vertex (#V) along the border; -1: it is not on the border.
struct BorderNeighbors {
  explicit BorderNeighbors(const TriangleMesh& mesh)
      : before(mesh.vertices.size(), -1), behind(mesh.vertices.size(), -1) {
    const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      for (int k = 0; k < 3; ++k) {
        if (neighbors[f][Index(k)] >= 0) continue;
        const int a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
        behind[Index(a)] = b;
        before[Index(b)] = a;
      }
    }
  }

  // Of a step, what leaves the border where it is: the part along it.
  Eigen::Vector3d Along(const TriangleMesh& mesh, size_t v, const Eigen::Vector3d& step) const {
    if (before[v] < 0 || behind[v] < 0) return step;
    const Eigen::Vector3d along =
        (mesh.vertices[Index(behind[v])] - mesh.vertices[Index(before[v])]).normalized();
    return along.dot(step) * along;
  }

  std::vector<int32_t> before, behind;
};

// Moves the vertices towards the mean of their neighbours, those on the border along it. False if
// none may.
bool SmoothVertices(const std::vector<uint8_t>& vertices, const BorderNeighbors& border,
                    Tangle* tangle) {
  TriangleMesh& mesh = tangle->mesh;
  std::vector<Eigen::Vector3d> sums(vertices.size(), Eigen::Vector3d::Zero());
  std::vector<int> counts(vertices.size(), 0);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const size_t v = Index(face[k]);
      if (!vertices[v]) continue;
      sums[v] += mesh.vertices[Index(face[(k + 1) % 3])] + mesh.vertices[Index(face[(k + 2) % 3])];
      counts[v] += 2;
    }
  }
  bool has_changed = false;
  for (size_t v = 0; v < sums.size(); ++v) {
    if (!vertices[v] || !tangle->may_move[v] || counts[v] == 0) continue;
    Eigen::Vector3d& x = mesh.vertices[v];
    const Eigen::Vector3d step = kStep * border.Along(mesh, v, sums[v] / counts[v] - x);
    if (step.norm() == 0) continue;
    x = RoundToFile(x + step, kMaxRoundingPart * step.norm());
    tangle->has_moved[v] = 1;
    has_changed = true;
  }
  return has_changed;
}

void SmoothFaults(const RunContext& context, Tangle* tangle) {
  const BorderNeighbors border(tangle->mesh);
  for (int step = 0; step < kMaxSteps; ++step) {
    const Faults faults = FindFaults(tangle->mesh, tangle->is_new,
                                     Either(tangle->has_moved, tangle->may_move), context);
    if (!HasOne(faults.faces)) return;
    std::vector<uint8_t> vertices = VerticesOf(tangle->mesh, faults.faces);
    // More and more around what does not come right.
    for (int ring = 0; ring < step / kStepsOfOneRing; ++ring) GrowByRing(tangle->mesh, &vertices);
    if (!SmoothVertices(vertices, border, tangle)) return;
  }
}

// The faces around those with a fault; vertices that other faces use must not move.
Tangle CutOut(const TriangleMesh& mesh, const std::vector<uint8_t>& faulty, size_t first_new,
              const std::vector<uint8_t>& may_move, const std::vector<uint8_t>& has_moved,
              std::vector<int32_t>* whole_vertex) {
  TriangleMesh faulty_mesh;
  faulty_mesh.vertices = mesh.vertices;
  for (size_t f = 0; f < faulty.size(); ++f) {
    if (faulty[f]) faulty_mesh.faces.push_back(mesh.faces[f]);
  }
  const std::vector<uint8_t> is_near =
      FacesNear(mesh, faulty_mesh, kReach * MeanEdgeLength(faulty_mesh));
  SourcedMesh whole;
  whole.mesh = mesh;
  whole.sources.resize(mesh.vertices.size());
  whole.is_changed = has_moved;
  MeshBand band = ExtractBand(whole, is_near);
  Tangle tangle;
  tangle.mesh = std::move(band.mesh);
  tangle.has_moved = std::move(band.is_changed);
  for (size_t v = 0; v < band.whole_vertex.size(); ++v) {
    tangle.may_move.push_back(may_move[Index(band.whole_vertex[v])] && !band.is_fixed[v]);
  }
  for (size_t f = 0; f < is_near.size(); ++f) {
    if (is_near[f]) tangle.is_new.push_back(f >= first_new);
  }
  *whole_vertex = std::move(band.whole_vertex);
  return tangle;
}

}  // namespace

std::vector<int32_t> UntangleFaces(const std::vector<uint8_t>& may_move, size_t first_new,
                                   const RunContext& context, std::vector<uint8_t>* has_moved,
                                   TriangleMesh* mesh) {
  std::vector<uint8_t> is_new(mesh->faces.size(), 0);
  std::fill(is_new.begin() + static_cast<std::ptrdiff_t>(first_new), is_new.end(), uint8_t{1});
  for (int round = 0;; ++round) {
    const Faults faults = FindFaults(*mesh, is_new, Either(*has_moved, may_move), context);
    if (round == kMaxRounds || !HasOne(faults.faces)) return faults.crossings;
    std::vector<int32_t> whole_vertex;
    Tangle tangle = CutOut(*mesh, faults.faces, first_new, may_move, *has_moved, &whole_vertex);
    SmoothFaults(context, &tangle);
    for (size_t v = 0; v < whole_vertex.size(); ++v) {
      mesh->vertices[Index(whole_vertex[v])] = tangle.mesh.vertices[v];
      (*has_moved)[Index(whole_vertex[v])] = tangle.has_moved[v];
    }
  }
}

}  // namespace lsmvs
