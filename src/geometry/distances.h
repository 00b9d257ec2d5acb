#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace lsmvs {

struct Triangle3 {
  Eigen::Vector3d a, b, c;
};

// Point of a triangle that is nearest to p. Triangles may be degenerate.
Eigen::Vector3d ClosestOnTriangle(const Eigen::Vector3d& p, const Triangle3& triangle);

// Weights of the corners of which a point in the plane of the triangle is the mean; those of the
// first corner alone where the triangle is degenerate.
Eigen::Vector3d BarycentricCoordinates(const Eigen::Vector3d& p, const Triangle3& triangle);

// Point of the segment ab that is nearest to p; the ends may coincide.
Eigen::Vector3d ClosestOnSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b);

// A triangle prepared for many questions; it may be degenerate.
class PreparedTriangle {
 public:
  explicit PreparedTriangle(const Triangle3& t)
      : a_(t.a), ab_(t.b - t.a), ac_(t.c - t.a), normal_(ab_.cross(ac_)) {
    const double area = normal_.norm();
    if (area > 0) normal_ /= area;
    inverse_area_ = 1.0 / (area * area);
  }

  // Square of the distance of p; some value above `limit` where that is larger than `limit`.
  double SquaredDistance(const Eigen::Vector3d& p, double limit) const {
    const Eigen::Vector3d ap = p - a_;
    const double height = normal_.dot(ap), squared_height = height * height;
    if (squared_height > limit) return squared_height;
    const double d1 = ab_.dot(ap), d2 = ac_.dot(ap);
    const double aa = ab_.squaredNorm(), bb = ac_.squaredNorm(), mixed = ab_.dot(ac_);
    const double v = (bb * d1 - mixed * d2) * inverse_area_;
    const double w = (aa * d2 - mixed * d1) * inverse_area_;
    // Not a number where the triangle is degenerate: then all its edges count.
    const bool by_ab = !(w >= 0), by_ac = !(v >= 0), by_bc = !(v + w <= 1);
    if (!by_ab && !by_ac && !by_bc) return squared_height;
    double least = std::numeric_limits<double>::infinity();
    if (by_ab) least = SquaredDistanceToVector(ap, ab_, d1, aa);
    if (by_ac) least = std::min(least, SquaredDistanceToVector(ap, ac_, d2, bb));
    if (by_bc) {
      const Eigen::Vector3d bp = ap - ab_, bc = ac_ - ab_;
      least = std::min(least, SquaredDistanceToVector(bp, bc, bc.dot(bp), bc.squaredNorm()));
    }
    return least;
  }

  // Largest share u of the way from p to q at which p + u (q - p) lies above or below the triangle,
  // at most 1; something below 0 where it never does or the triangle is degenerate.
  double ExitShare(const Eigen::Vector3d& p, const Eigen::Vector3d& q) const {
    // A little larger than it is, so that a way along an edge is not lost by rounding.
    const Eigen::Vector3d at_p = Coordinates(p).array() + 1e-9,
                          at_q = Coordinates(q).array() + 1e-9;
    if (!at_p.allFinite()) return -1;
    double enter = 0, exit = 1;
    for (int k = 0; k < 3; ++k) {
      const double change = at_q[k] - at_p[k];
      if (change < 0) exit = std::min(exit, -at_p[k] / change);
      if (change > 0) enter = std::max(enter, -at_p[k] / change);
      if (!(change != 0 || at_p[k] >= 0)) return -1;
    }
    return enter <= exit ? exit : -1;
  }

 private:
  // Barycentric coordinates of a point's projection.
  Eigen::Vector3d Coordinates(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d ap = p - a_;
    const double d1 = ab_.dot(ap), d2 = ac_.dot(ap);
    const double aa = ab_.squaredNorm(), bb = ac_.squaredNorm(), mixed = ab_.dot(ac_);
    const double v = (bb * d1 - mixed * d2) * inverse_area_;
    const double w = (aa * d2 - mixed * d1) * inverse_area_;
    return {1 - v - w, v, w};
  }
  static double SquaredDistanceToVector(const Eigen::Vector3d& p, const Eigen::Vector3d& end,
                                        double product, double squared_length) {
    const double share = squared_length > 0 ? std::clamp(product / squared_length, 0.0, 1.0) : 0.0;
    return (p - share * end).squaredNorm();
  }

  Eigen::Vector3d a_, ab_, ac_, normal_;
  double inverse_area_;
};

}  // namespace lsmvs
