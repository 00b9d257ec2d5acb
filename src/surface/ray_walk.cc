#include "lsmvs/surface/ray_walk.h"

#include <cmath>

namespace lsmvs {

namespace {

// T. Duff et al.: Building an orthonormal basis, revisited, JCGT 6(1), 2017.
void SetFrame(const Eigen::Vector3d& direction, RayWalker::Ray* ray) {
  const double x = direction.x(), y = direction.y(), z = direction.z();
  const double sign = std::copysign(1.0, z), a = -1.0 / (sign + z), b = x * y * a;
  ray->u = {1.0 + sign * x * x * a, sign * b, -sign * x};
  ray->v = {b, sign + y * y * a, -y};
  ray->w = direction;
}

}  // namespace

bool RayWalker::TurnsLeftTilted(const Projected& a, const Projected& b) {
  // The target moves by (e, e^2), so that (x, y) becomes (x - e z, y - e^2 z): terms in e, then in
  // e^2.
  const double first = static_cast<double>(a.y) * b.z - static_cast<double>(a.z) * b.y;
  if (first != 0) return first > 0;
  const double second = static_cast<double>(a.z) * b.x - static_cast<double>(a.x) * b.z;
  if (second != 0) return second > 0;
  return a.vertex < b.vertex;
}

double RayWalker::Depth(const std::array<Projected, 3>& corners) {
  const auto turn = [&](int i, int j) {
    return static_cast<double>(corners[i].x) * corners[j].y -
           static_cast<double>(corners[i].y) * corners[j].x;
  };
  const double a = turn(1, 2), b = turn(2, 0), c = turn(0, 1), sum = a + b + c;
  if (sum <= 0) return std::min({corners[0].z, corners[1].z, corners[2].z});
  return (a * corners[0].z + b * corners[1].z + c * corners[2].z) / sum;
}

bool RayWalker::Start(int32_t vertex, const Eigen::Vector3d& direction, double length,
                      double near_distance, Ray* ray) const {
  ray->origin = complex_.points[vertex].cast<double>();
  SetFrame(direction, ray);
  ray->length = length;
  ray->near = static_cast<float>(near_distance);
  ray->far = static_cast<float>(length);
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
