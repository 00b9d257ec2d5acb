#include "lsmvs/merging/zip/untangling.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "lsmvs/mesh/face_crossings.h"
#include "lsmvs/mesh/face_neighbors.h"

namespace lsmvs {

namespace {

constexpr int kMaxSteps = 40, kStepsOfOneRing = 4;
constexpr double kStep = 0.6;
// Neighbours whose normals enclose more than this are folded.
constexpr double kFoldCosine = -0.7;
constexpr double kMaxRoundingPart = 1e-4;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

class Untangler {
 public:
  Untangler(const std::vector<uint8_t>& may_move, const RunContext& context,
            std::vector<uint8_t>* is_active, std::vector<uint8_t>* has_moved, TriangleMesh* mesh)
      : may_move_(may_move),
        context_(context),
        is_active_(*is_active),
        has_moved_(*has_moved),
        mesh_(*mesh),
        neighbors_(FindFaceNeighbors(mesh->faces, mesh->vertices.size())) {}

  size_t Run() {
    size_t num_crossing = 0;
    for (int step = 0; step < kMaxSteps; ++step) {
      num_crossing = FindBadVertices();
      if (!HasBadVertices()) break;
      // More and more around what does not come right.
      for (int ring = 0; ring < step / kStepsOfOneRing; ++ring) GrowBadVertices();
      if (!SmoothBadVertices()) break;
    }
    return num_crossing;
  }

 private:
  size_t FindBadVertices() {
    is_bad_.assign(mesh_.vertices.size(), 0);
    const FaceGrid grid(mesh_.vertices, mesh_.faces);
    const auto pairs = grid.CrossingPairs(is_active_, context_);
    for (const auto& [a, b] : pairs) {
      MarkFace(Index(a));
      MarkFace(Index(b));
    }
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (!is_active_[f]) continue;
      for (const int32_t other : neighbors_[f]) {
        if (other < 0) continue;
        const Eigen::Vector3d a = FaceNormalTimesTwiceArea(mesh_, f),
                              b = FaceNormalTimesTwiceArea(mesh_, Index(other));
        if (a.dot(b) < kFoldCosine * a.norm() * b.norm()) {
          MarkFace(f);
          MarkFace(Index(other));
        }
      }
    }
    return pairs.size();
  }

  void MarkFace(size_t f) {
    for (const int v : mesh_.faces[f]) is_bad_[Index(v)] = 1;
  }
  bool HasBadVertices() const {
    return std::any_of(is_bad_.begin(), is_bad_.end(), [](uint8_t bad) { return bad != 0; });
  }

  void GrowBadVertices() {
    const std::vector<uint8_t> before = is_bad_;
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      const Eigen::Vector3i& face = mesh_.faces[f];
      if (before[Index(face[0])] || before[Index(face[1])] || before[Index(face[2])]) MarkFace(f);
    }
  }

  bool SmoothBadVertices() {
    std::vector<Eigen::Vector3d> sums(mesh_.vertices.size(), Eigen::Vector3d::Zero());
    std::vector<int> counts(mesh_.vertices.size(), 0);
    for (const Eigen::Vector3i& face : mesh_.faces) {
      for (int k = 0; k < 3; ++k) {
        const size_t v = Index(face[k]);
        if (!is_bad_[v]) continue;
        sums[v] += mesh_.vertices[Index(face[(k + 1) % 3])] +
                   mesh_.vertices[Index(face[(k + 2) % 3])];
        counts[v] += 2;
      }
    }
    bool has_changed = false;
    for (size_t v = 0; v < sums.size(); ++v) {
      if (!is_bad_[v] || !may_move_[v] || counts[v] == 0) continue;
      Eigen::Vector3d& x = mesh_.vertices[v];
      const Eigen::Vector3d step = kStep * (sums[v] / counts[v] - x);
      if (step.norm() == 0) continue;
      x = RoundToFile(x + step, kMaxRoundingPart * step.norm());
      has_moved_[v] = 1;
      has_changed = true;
    }
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      for (const int v : mesh_.faces[f]) is_active_[f] |= is_bad_[Index(v)] && may_move_[Index(v)];
    }
    return has_changed;
  }

  const std::vector<uint8_t>& may_move_;
  const RunContext& context_;
  std::vector<uint8_t>& is_active_;
  std::vector<uint8_t>& has_moved_;
  TriangleMesh& mesh_;
  FaceNeighbors neighbors_;
  std::vector<uint8_t> is_bad_;  // #V
};

}  // namespace

size_t UntangleFaces(const std::vector<uint8_t>& may_move, const RunContext& context,
                     std::vector<uint8_t>* is_active, std::vector<uint8_t>* has_moved,
                     TriangleMesh* mesh) {
  return Untangler(may_move, context, is_active, has_moved, mesh).Run();
}

}  // namespace lsmvs
