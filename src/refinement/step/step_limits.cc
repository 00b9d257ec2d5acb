#include "lsmvs/refinement/step/step_limits.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace lsmvs {

namespace {

// What a rim may go further than the surface beside it.
constexpr double kRimSlackPx = 1.5;
constexpr double kMaxRoundingPx = 1e-3;
// A step may turn a face by at most this cosine.
constexpr double kMinTurnCosine = 0.3;
constexpr int kFoldPasses = 3;

// Pixels from the input to where a step leads.
double WayFromInput(const SurfaceBeforeStep& surface, size_t v, const std::vector<double>& step) {
  const Eigen::Vector3d way = surface.mesh.vertices[v] - surface.input[v];
  return surface.directions[v].dot(way) / surface.pixel_size[v] + step[v];
}

// Whether a step turns a face further away from the directions of its vertices than is allowed.
bool Folds(const SurfaceBeforeStep& surface, const std::vector<Eigen::Vector3d>& positions,
           size_t f) {
  const Eigen::Vector3i& face = surface.mesh.faces[f];
  Eigen::Vector3d around = Eigen::Vector3d::Zero();
  for (const int v : face) around += surface.directions[static_cast<size_t>(v)];
  const Eigen::Vector3d& a = positions[static_cast<size_t>(face[0])];
  const Eigen::Vector3d after = (positions[static_cast<size_t>(face[1])] - a)
                                    .cross(positions[static_cast<size_t>(face[2])] - a);
  const double cosine = after.dot(around) / (after.norm() * around.norm());
  if (cosine >= kMinTurnCosine) return false;
  const Eigen::Vector3d before = FaceNormalTimesTwiceArea(surface.mesh, f);
  return !(cosine >= before.dot(around) / (before.norm() * around.norm()));
}

}  // namespace

std::vector<Eigen::Vector3d> Displaced(const SurfaceBeforeStep& surface,
                                       const std::vector<double>& step) {
  std::vector<Eigen::Vector3d> positions = surface.mesh.vertices;
  for (size_t v = 0; v < positions.size(); ++v) {
    positions[v] += step[v] * surface.pixel_size[v] * surface.directions[v];
    positions[v] = RoundToFile(positions[v], kMaxRoundingPx * surface.pixel_size[v]);
  }
  return positions;
}

void HoldRims(const SurfaceBeforeStep& surface, std::vector<double>* step) {
  const VertexRings& rings = surface.rings;
  for (size_t v = 0; v < step->size(); ++v) {
    if (!surface.on_rim[v] || surface.fixed[v]) continue;
    double sum = 0;
    int count = 0;
    for (auto k = rings.begin[v]; k < rings.begin[v + 1]; ++k) {
      const auto j = static_cast<size_t>(rings.neighbors[static_cast<size_t>(k)]);
      if (surface.on_rim[j] || surface.fixed[j]) continue;
      sum += WayFromInput(surface, j, *step);
      ++count;
    }
    if (count == 0) continue;
    const double inside = sum / count, way = WayFromInput(surface, v, *step);
    (*step)[v] += std::clamp(way, inside - kRimSlackPx, inside + kRimSlackPx) - way;
  }
}

void StopFolds(const SurfaceBeforeStep& surface, std::vector<double>* step) {
  for (int pass = 0; pass < kFoldPasses; ++pass) {
    const std::vector<Eigen::Vector3d> positions = Displaced(surface, *step);
    bool any = false;
    for (size_t f = 0; f < surface.mesh.faces.size(); ++f) {
      if (!Folds(surface, positions, f)) continue;
      any = true;
      for (const int v : surface.mesh.faces[f]) (*step)[static_cast<size_t>(v)] = 0;
    }
    if (!any) return;
  }
}

}  // namespace lsmvs
