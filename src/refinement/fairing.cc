#include "lsmvs/refinement/fairing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lsmvs/mesh/repair.h"
#include "lsmvs/refinement/smoothness.h"
#include "lsmvs/refinement/step_collisions.h"

namespace lsmvs {

namespace {

constexpr size_t kBlock = 8192;
constexpr double kStep = 0.5;

class CrumbSmoother {
 public:
  CrumbSmoother(const FairingOptions& options, TriangleMesh* mesh, const RunContext& context)
      : options_(options),
        mesh_(*mesh),
        context_(context),
        rings_(BuildVertexRings(*mesh)),
        moved_(mesh->vertices.size(), 0) {}

  size_t Run() {
    const std::vector<Eigen::Vector3d> before = mesh_.vertices;
    for (int round = 0; round < options_.num_rounds; ++round) {
      const std::vector<uint8_t> marks = MarkCrumbs();
      if (std::find(marks.begin(), marks.end(), 1) == marks.end()) break;
      for (int k = 0; k < options_.num_iterations; ++k) Smooth(marks);
      for (size_t v = 0; v < marks.size(); ++v) moved_[v] |= marks[v];
    }
    UndoCollisions(mesh_.faces, before, &mesh_.vertices, context_);
    return static_cast<size_t>(std::count(moved_.begin(), moved_.end(), 1));
  }

 private:
  size_t First(size_t v) const { return static_cast<size_t>(rings_.begin[v]); }
  template <class Visit>
  void ForNeighbors(size_t v, const Visit& visit) const {
    for (size_t k = First(v); k < First(v + 1); ++k) {
      visit(static_cast<size_t>(rings_.neighbors[k]));
    }
  }

  // Vector area of the patch around each vertex.
  std::vector<Eigen::Vector3d> MeanNormals() const {
    std::vector<Eigen::Vector3d> sums(mesh_.vertices.size(), Eigen::Vector3d::Zero());
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, f);
      for (const int v : mesh_.faces[f]) sums[static_cast<size_t>(v)] += normal;
    }
    std::vector<Eigen::Vector3d> wider(sums.size());
    for (int ring = 0; ring < options_.mean_rings; ++ring) {
      ParallelFor(context_, sums.size(), kBlock, [&](size_t v) {
        wider[v] = sums[v];
        ForNeighbors(v, [&](size_t j) { wider[v] += sums[j]; });
      });
      sums.swap(wider);
    }
    return sums;
  }

  // Vertices of crumbs and their neighbours.
  std::vector<uint8_t> MarkCrumbs() const {
    std::vector<uint8_t> found(mesh_.vertices.size(), 0);
    for (const int32_t f : SmallPieces(FindCrumbs())) {
      for (const int v : mesh_.faces[static_cast<size_t>(f)]) found[static_cast<size_t>(v)] = 1;
    }
    std::vector<uint8_t> marks = found;
    for (size_t v = 0; v < marks.size(); ++v) {
      ForNeighbors(v, [&](size_t j) { marks[v] |= found[j]; });
      if (rings_.on_border[v]) marks[v] = 0;
    }
    return marks;
  }

  // Faces that turn far from what is around them.
  std::vector<int32_t> FindCrumbs() const {
    const std::vector<Eigen::Vector3d> means = MeanNormals();
    const double least = std::cos(options_.max_angle_deg * std::numbers::pi / 180);
    std::vector<int32_t> crumbs;
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, f);
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const int v : mesh_.faces[f]) mean += means[static_cast<size_t>(v)];
      if (normal.dot(mean) < least * normal.norm() * mean.norm()) {
        crumbs.push_back(static_cast<int32_t>(f));
      }
    }
    return crumbs;
  }

  // Of the faces, those that hang together (across vertices) in pieces of few.
  std::vector<int32_t> SmallPieces(const std::vector<int32_t>& faces) const {
    TriangleMesh pieces;
    pieces.vertices.resize(mesh_.vertices.size());
    for (const int32_t f : faces) pieces.faces.push_back(mesh_.faces[static_cast<size_t>(f)]);
    const MeshComponents components = FindComponents(pieces);
    std::vector<int32_t> result;
    for (size_t k = 0; k < faces.size(); ++k) {
      const size_t size = components.num_faces[static_cast<size_t>(components.of_face[k])];
      if (size <= static_cast<size_t>(options_.max_faces)) result.push_back(faces[k]);
    }
    return result;
  }

  void Smooth(const std::vector<uint8_t>& marks) {
    std::vector<Eigen::Vector3d> next = mesh_.vertices;
    ParallelFor(context_, marks.size(), kBlock, [&](size_t v) {
      if (!marks[v]) return;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      ForNeighbors(v, [&](size_t j) { sum += mesh_.vertices[j]; });
      const auto count = static_cast<double>(First(v + 1) - First(v));
      next[v] += kStep * (sum / count - mesh_.vertices[v]);
    });
    mesh_.vertices.swap(next);
  }

  const FairingOptions& options_;
  TriangleMesh& mesh_;
  const RunContext& context_;
  const VertexRings rings_;
  std::vector<uint8_t> moved_;  // #V
};

}  // namespace

size_t SmoothCrumbs(const FairingOptions& options, TriangleMesh* mesh, const RunContext& context) {
  return CrumbSmoother(options, mesh, context).Run();
}

}  // namespace lsmvs
