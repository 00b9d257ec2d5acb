#include "lsmvs/merging/seam/blending.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lsmvs/mesh/face_neighbors.h"

namespace lsmvs {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kNumRimSteps = 12, kNumFieldSteps = 4;
// Widths of the bands in which a vertex follows its own match, and the smooth offset of the rim, in
// edge lengths; and of the latter in units of the way that the rim moves, which is the inverse of
// its slope. Narrower bands move less of the mesh that is right, but steeper ones have more area.
constexpr double kOwnWidth = 2, kSmoothWidth = 3, kInverseSlope = 4;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

// From 1 at 0 to 0 at 1, flat at both ends.
double Fade(double t) {
  if (t >= 1) return 0;
  return 1 - t * t * (3 - 2 * t);
}

std::vector<uint8_t> RimVertices(const TriangleMesh& mesh, const std::vector<uint8_t>& kept) {
  std::vector<uint8_t> on_rim(mesh.vertices.size(), 0);
  const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
  for (size_t f = 0; f < kept.size(); ++f) {
    for (int k = 0; k < 3 && kept[f]; ++k) {
      const int32_t other = neighbors[f][Index(k)];
      if (other < 0 || kept[Index(other)]) continue;
      on_rim[Index(mesh.faces[f][k])] = on_rim[Index(mesh.faces[f][(k + 1) % 3])] = 1;
    }
  }
  return on_rim;
}

// Offsets of the rim's vertices, smoothed along it; those without a match take their neighbours'.
std::vector<Eigen::Vector3d> SmoothRimOffsets(const OverlapSide& side,
                                              const std::vector<uint8_t>& on_rim) {
  const size_t num_vertices = on_rim.size();
  std::vector<Eigen::Vector3d> offsets(num_vertices, Eigen::Vector3d::Zero());
  std::vector<uint8_t> is_known(num_vertices, 0);
  for (size_t v = 0; v < num_vertices; ++v) {
    if (!on_rim[v] || side.matches[v].face < 0 || side.matches[v].at_border) continue;
    offsets[v] = side.matches[v].point - side.surface->mesh().vertices[v];
    is_known[v] = 1;
  }
  for (int step = 0; step < kNumRimSteps; ++step) {
    const std::vector<Eigen::Vector3d> before = offsets;
    const std::vector<uint8_t> known_before = is_known;
    for (size_t v = 0; v < num_vertices; ++v) {
      if (!on_rim[v]) continue;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
      const auto add = [&](size_t w) {
        if (!on_rim[w] || !known_before[w]) return;
        sum += before[w];
        ++count;
      };
      add(v);
      side.surface->topology.ForNeighbors(static_cast<int32_t>(v),
                                          [&](int32_t w) { add(Index(w)); });
      if (count == 0) continue;
      offsets[v] = sum / count;
      is_known[v] = 1;
    }
  }
  return offsets;
}

}  // namespace

std::vector<Eigen::Vector3d> BlendTowardsMatches(const OverlapSide& side,
                                                 const std::vector<uint8_t>& kept_faces,
                                                 double share, double min_width, double max_width,
                                                 std::vector<uint8_t>* may_move) {
  const TriangleMesh& mesh = side.surface->mesh();
  const size_t num_vertices = mesh.vertices.size();
  const std::vector<uint8_t> on_rim = RimVertices(mesh, kept_faces);
  const std::vector<Eigen::Vector3d> rim_offsets = SmoothRimOffsets(side, on_rim);
  std::vector<double> start(num_vertices, kInfinity);
  for (size_t v = 0; v < num_vertices; ++v) {
    if (on_rim[v]) start[v] = 0;
  }
  std::vector<int32_t> nearest;
  const std::vector<double> from_rim =
      DistanceAlongEdges(mesh, side.surface->topology, std::move(start), max_width, &nearest);
  std::vector<Eigen::Vector3d> smooth(num_vertices, Eigen::Vector3d::Zero());
  std::vector<double> width(num_vertices, 0);
  for (size_t v = 0; v < num_vertices; ++v) {
    if (nearest[v] < 0) continue;
    const size_t rim = Index(nearest[v]);
    smooth[v] = share * rim_offsets[rim];
    width[v] = std::min(max_width, std::max(kSmoothWidth * side.surface->frames.edge_length[rim],
                                            kInverseSlope * smooth[v].norm()));
  }
  // Where the nearest rim changes from one vertex to the next.
  for (int step = 0; step < kNumFieldSteps; ++step) {
    const std::vector<Eigen::Vector3d> before = smooth;
    for (size_t v = 0; v < num_vertices; ++v) {
      if (nearest[v] < 0) continue;
      Eigen::Vector3d sum = before[v];
      int count = 1;
      side.surface->topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
        if (nearest[Index(w)] < 0) return;
        sum += before[Index(w)];
        ++count;
      });
      smooth[v] = sum / count;
    }
  }
  std::vector<Eigen::Vector3d> displacements(num_vertices, Eigen::Vector3d::Zero());
  may_move->assign(num_vertices, 0);
  for (size_t v = 0; v < num_vertices; ++v) {
    if (nearest[v] < 0) continue;
    if (side.surface->band->is_fixed[v]) continue;
    const double distance = from_rim[v];
    (*may_move)[v] = distance < std::max(width[v], min_width);
    const double edge = side.surface->frames.edge_length[v];
    Eigen::Vector3d& moved = displacements[v];
    moved = Fade(distance / width[v]) * smooth[v];
    const SurfaceMatch& match = side.matches[v];
    if (match.face < 0 || match.at_border) continue;
    const Eigen::Vector3d own = share * (match.point - mesh.vertices[v]);
    moved += Fade(distance / (kOwnWidth * edge)) * (own - smooth[v]);
    if (moved.norm() < 1e-7 * edge) moved.setZero();
  }
  return displacements;
}

}  // namespace lsmvs
