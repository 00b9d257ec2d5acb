#include <Eigen/LU>
#include <cmath>

#include "lsmvs/stereo/quasi_dense/planes.h"

namespace lsmvs::quasi_dense {

namespace {

constexpr int kNumRounds = 3;
constexpr int kMinPoints = 5;
constexpr int kMaxReach = 3;
constexpr int kMaxPoints = (2 * kMaxReach + 1) * (2 * kMaxReach + 1);

// Matched points around, relative to the centre: offsets in cells, inverse depth in tolerances off
// the guess.
struct Samples {
  int count = 0;
  float x[kMaxPoints], y[kMaxPoints], z[kMaxPoints];
};

Samples Gather(const PointGrid& grid, const Eigen::Vector2f& position, const Plane& guess,
               float tolerance, int reach) {
  Samples samples;
  const float per_cell = 1.0f / grid.spacing, per_tolerance = 1.0f / tolerance;
  ForPointsAround(grid, position, std::min(reach, kMaxReach), [&](const InterestPoint& point) {
    if (!point.matched()) return;
    const Eigen::Vector2f offset = (point.position - position) * per_cell;
    samples.x[samples.count] = offset.x();
    samples.y[samples.count] = offset.y();
    samples.z[samples.count] = (point.plane.q - guess.q) * per_tolerance;
    ++samples.count;
  });
  return samples;
}

// Symmetric 3 x 3 system of weighted least squares for z = c + a x + b y, and its solution (c, a,
// b). False where it is singular.
bool SolveRound(const Samples& samples, const Eigen::Vector3f& previous, Eigen::Vector3f* result) {
  float s0 = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, sz = 0, sxz = 0, syz = 0;
  for (int k = 0; k < samples.count; ++k) {
    const float x = samples.x[k], y = samples.y[k], z = samples.z[k];
    const float error = z - (previous[0] + previous[1] * x + previous[2] * y);
    const float weight = 1.0f / (1.0f + error * error);
    s0 += weight;
    sx += weight * x;
    sy += weight * y;
    sz += weight * z;
    sxx += weight * x * x;
    sxy += weight * x * y;
    syy += weight * y * y;
    sxz += weight * x * z;
    syz += weight * y * z;
  }
  if (!(s0 > 1.5f)) return false;
  Eigen::Matrix3f matrix;
  matrix << s0, sx, sy, sx, sxx, sxy, sy, sxy, syy;
  const float determinant = matrix.determinant();
  if (!(determinant > 1e-3f * s0 * s0 * s0)) return false;
  *result = matrix.inverse() * Eigen::Vector3f(sz, sxz, syz);
  return result->allFinite();
}

}  // namespace

Plane FitPlane(const PointGrid& grid, const Eigen::Vector2f& position, const Plane& guess,
               float tolerance, int reach) {
  const Samples samples = Gather(grid, position, guess, tolerance, reach);
  if (samples.count < kMinPoints) return guess;
  const float cells_per_tolerance = grid.spacing / tolerance;
  Eigen::Vector3f fit(0, guess.qx * cells_per_tolerance, guess.qy * cells_per_tolerance);
  for (int round = 0; round < kNumRounds; ++round) {
    if (!SolveRound(samples, fit, &fit)) return guess;
  }
  const Plane plane{guess.q + fit[0] * tolerance, fit[1] / cells_per_tolerance,
                    fit[2] / cells_per_tolerance};
  return plane.known() ? plane : guess;
}

Plane MovePlane(const Plane& plane, const Eigen::Vector2f& offset, const Eigen::Vector2f& scale) {
  const Plane moved = plane.Moved(offset.x(), offset.y());
  return {moved.q, moved.qx / scale.x(), moved.qy / scale.y()};
}

}  // namespace lsmvs::quasi_dense
