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
    const double aa = ab_.squaredNorm(), bb = ac_.squaredNorm(), mixed = ab_.dot(ac_);
    const double squared_area = normal_.squaredNorm();
    inverse_ = 1.0 / squared_area;
    to_b_ = inverse_ * (bb * ab_ - mixed * ac_);
    to_c_ = inverse_ * (aa * ac_ - mixed * ab_);
    squared_heights_ = {squared_area / (ac_ - ab_).squaredNorm(), squared_area / bb,
                        squared_area / aa};
  }

  // Square of the distance of p; some value above `limit`, at most that square, where that is
  // larger than `limit`.
  double SquaredDistance(const Eigen::Vector3d& p, double limit) const {
    const Eigen::Vector3d ap = p - a_;
    const double offset = normal_.dot(ap), squared_height = inverse_ * offset * offset;
    if (squared_height > limit) return squared_height;
    const double v = to_b_.dot(ap), w = to_c_.dot(ap), u = 1 - v - w;
    // How far beyond the line of an edge: nearer than that no point of the triangle is.
    const auto beyond = [&](double coordinate, int k) {
      const double outside = std::min(coordinate, 0.0);
      return outside * outside * squared_heights_[k];
    };
    const double least_possible =
        squared_height + std::max({beyond(u, 0), beyond(v, 1), beyond(w, 2)});
    if (least_possible > limit) return least_possible;
    // Not a number where the triangle is degenerate: then all its edges count.
    const bool by_ab = !(w >= 0), by_ac = !(v >= 0), by_bc = !(u >= 0);
    if (!by_ab && !by_ac && !by_bc) return squared_height;
    double least = std::numeric_limits<double>::infinity();
    if (by_ab) least = SquaredDistanceToVector(ap, ab_);
    if (by_ac) least = std::min(least, SquaredDistanceToVector(ap, ac_));
    if (by_bc) least = std::min(least, SquaredDistanceToVector(ap - ab_, ac_ - ab_));
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
    const double v = to_b_.dot(ap), w = to_c_.dot(ap);
    return {1 - v - w, v, w};
  }
  static double SquaredDistanceToVector(const Eigen::Vector3d& p, const Eigen::Vector3d& end) {
    const double squared_length = end.squaredNorm();
    const double share =
        squared_length > 0 ? std::clamp(end.dot(p) / squared_length, 0.0, 1.0) : 0.0;
    return (p - share * end).squaredNorm();
  }

  Eigen::Vector3d a_, ab_, ac_, normal_;  // normal: times twice the area
  Eigen::Vector3d to_b_, to_c_;           // gradients of the second and third coordinate
  Eigen::Vector3d squared_heights_;       // of the corners above the opposite edges
  double inverse_;                        // of the squared length of the normal
};

}  // namespace lsmvs
