#include "lsmvs/surface/weights/ray_walk.h"

#include <cmath>

namespace lsmvs {

namespace {

// T. Duff et al.: Building an orthonormal basis, revisited, JCGT 6(1), 2017.
void SetFrame(const Eigen::Vector3d& direction, RayWalker::Ray* ray) {
  const double x = direction.x(), y = direction.y(), z = direction.z();
  const double sign = std::copysign(1.0, z), a = -1.0 / (sign + z), b = x * y * a;
  Eigen::Matrix<double, 4, 3> frame;
  frame.row(0) << 1.0 + sign * x * x * a, sign * b, -sign * x;
  frame.row(1) << b, sign + y * y * a, -y;
  frame.row(2) = direction.transpose();
  frame.row(3).setZero();
  for (int k = 0; k < 3; ++k) ray->axes[k] = frame.col(k).cast<float>();
}

}  // namespace

bool RayWalker::TurnsLeftTilted(const Projected& a, const Projected& b) {
  // The target moves by (e, e^2), so that (x, y) becomes (x - e z, y - e^2 z): terms in e, then in
  // e^2.
  const Eigen::Vector4d p = a.x.cast<double>(), q = b.x.cast<double>();
  const double first = p[1] * q[2] - p[2] * q[1];
  if (first != 0) return first > 0;
  const double second = p[2] * q[0] - p[0] * q[2];
  if (second != 0) return second > 0;
  return a.vertex < b.vertex;
}

RayWalker::RayWalker(const Tetrahedralization& complex) : complex_(complex) {
  points_.reserve(complex.points.size());
  for (const Eigen::Vector3f& x : complex.points) points_.emplace_back(x.x(), x.y(), x.z(), 0.0f);
}

double RayWalker::Depth(const std::array<Projected, 3>& corners) {
  const Eigen::Vector4f &p = corners[0].x, &q = corners[1].x, &r = corners[2].x;
  const auto turn = [](const Eigen::Vector4f& s, const Eigen::Vector4f& t) {
    return static_cast<double>(s[0]) * t[1] - static_cast<double>(s[1]) * t[0];
  };
  const double a = turn(q, r), b = turn(r, p), c = turn(p, q), sum = a + b + c;
  if (sum <= 0) return std::min({p[2], q[2], r[2]});
  return (a * p[2] + b * q[2] + c * r[2]) / sum;
}

bool RayWalker::Start(int32_t vertex, const Eigen::Vector3d& direction, double length,
                      double near_distance, Ray* ray) const {
  ray->origin = points_[vertex];
  SetFrame(direction, ray);
  ray->length = static_cast<float>(length);
  ray->near = static_cast<float>(near_distance);
  ray->careful = true;
  ray->num_crossings = 0;
  const int exit = FindStart(vertex, ray);
  if (exit < 0) return false;
  LeaveThrough(exit, ray);
  return true;
}

int RayWalker::FindStart(int32_t vertex, Ray* ray) const {
  // Towards the ray through the facets at the vertex; in a Delaunay complex such walks end.
  constexpr int kMaxSteps = 1000000;
  int32_t& current = ray->current = complex_.incident_cell[vertex];
  for (int step = 0; step < kMaxSteps; ++step) {
    if (complex_.IsInfinite(current)) return -1;
    const Cell& cell = complex_.cells[current];
    const int k = cell.IndexOfVertex(vertex);
    const auto& facet = kFacetVertices[k];
    // Counter-clockwise from outside: the ray that leaves through it turns left around it.
    auto& [a, b, c] = ray->corners;
    a = Project(*ray, cell.vertex[facet[0]]);
    b = Project(*ray, cell.vertex[facet[2]]);
    c = Project(*ray, cell.vertex[facet[1]]);
    if (!TurnsLeft(a, b)) {
      current = cell.neighbor[facet[1]];
    } else if (!TurnsLeft(b, c)) {
      current = cell.neighbor[facet[0]];
    } else if (!TurnsLeft(c, a)) {
      current = cell.neighbor[facet[2]];
    } else {
      return k;
    }
  }
  current = -1;
  return -1;
}

}  // namespace lsmvs
