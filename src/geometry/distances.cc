#include "lsmvs/geometry/distances.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace lsmvs {

// By the Voronoi regions of its corners, edges and inside (Ericson, Real-Time Collision Detection,
// 2005, 5.1.5).
Eigen::Vector3d ClosestOnTriangle(const Eigen::Vector3d& p, const Triangle3& t) {
  const Eigen::Vector3d ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a, bp = p - t.b, cp = p - t.c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t.a;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t.b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return t.a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t.c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t.a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double step = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 >= d3 && d5 >= d6 && step > 0) return t.b + (d4 - d3) / step * (t.c - t.b);
  const double sum = va + vb + vc;
  if (!(sum > 0)) return t.a;  // a degenerate triangle that rounding brought here
  return t.a + vb / sum * ab + vc / sum * ac;
}

Eigen::Vector3d BarycentricCoordinates(const Eigen::Vector3d& p, const Triangle3& t) {
  const Eigen::Vector3d normal = (t.b - t.a).cross(t.c - t.a);
  const double area = normal.squaredNorm();
  if (!(area > 0)) return {1, 0, 0};
  const double b = (p - t.a).cross(t.c - t.a).dot(normal) / area;
  const double c = (t.b - t.a).cross(p - t.a).dot(normal) / area;
  return {1 - b - c, b, c};
}

Eigen::Vector3d ClosestOnSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length = ab.squaredNorm();
  if (!(length > 0)) return a;
  return a + std::clamp(ab.dot(p - a) / length, 0.0, 1.0) * ab;
}

}  // namespace lsmvs
