#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace lsmvs::internal {

// Exact signs of determinants over points with float coordinates: evaluated in double precision,
// whose error is bounded (J. Shewchuk: Adaptive precision floating-point arithmetic and fast robust
// geometric predicates, 1997), and exactly where the bound does not decide.

int ExactOrientation(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                     const Eigen::Vector3f& d);
int ExactInSphere(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                  const Eigen::Vector3f& d, const Eigen::Vector3f& e);

struct Difference {
  double x, y, z;
  Difference(const Eigen::Vector3f& p, const Eigen::Vector3f& q)
      : x(static_cast<double>(p.x()) - q.x()),
        y(static_cast<double>(p.y()) - q.y()),
        z(static_cast<double>(p.z()) - q.z()) {}
  double Squared() const { return x * x + y * y + z * z; }
};

// Sign of (b-a) x (c-a) . (d-a): +1 if d lies on the side from which a, b, c turn
// counter-clockwise.
inline int Orientation(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                       const Eigen::Vector3f& d) {
  const Difference p(b, a), q(c, a), r(d, a);
  const double determinant =
      p.x * (q.y * r.z - q.z * r.y) + p.y * (q.z * r.x - q.x * r.z) + p.z * (q.x * r.y - q.y * r.x);
  const double mx = std::max({std::abs(p.x), std::abs(q.x), std::abs(r.x)});
  const double my = std::max({std::abs(p.y), std::abs(q.y), std::abs(r.y)});
  const double mz = std::max({std::abs(p.z), std::abs(q.z), std::abs(r.z)});
  // The permanent is at most 6 mx my mz; 7 roundings of 2^-53 each, and those of the differences.
  const double bound = 7e-15 * mx * my * mz;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return ExactOrientation(a, b, c, d);
}

// +1 if e lies inside of the sphere through the positively oriented a, b, c, d, -1 outside, 0 on
// it.
inline int InSphere(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                    const Eigen::Vector3f& d, const Eigen::Vector3f& e) {
  const Difference p(a, e), q(b, e), r(c, e), s(d, e);
  const double pq = p.x * q.y - q.x * p.y, qr = q.x * r.y - r.x * q.y;
  const double rs = r.x * s.y - s.x * r.y, sp = s.x * p.y - p.x * s.y;
  const double pr = p.x * r.y - r.x * p.y, qs = q.x * s.y - s.x * q.y;
  const double pqr = p.z * qr - q.z * pr + r.z * pq, qrs = q.z * rs - r.z * qs + s.z * qr;
  const double rsp = r.z * sp + s.z * pr + p.z * rs, spq = s.z * pq + p.z * qs + q.z * sp;
  const double pp = p.Squared(), qq = q.Squared(), rr = r.Squared(), ss = s.Squared();
  const double determinant = (rr * spq - ss * pqr) + (pp * qrs - qq * rsp);
  const double mx = std::max({std::abs(p.x), std::abs(q.x), std::abs(r.x), std::abs(s.x)});
  const double my = std::max({std::abs(p.y), std::abs(q.y), std::abs(r.y), std::abs(s.y)});
  const double mz = std::max({std::abs(p.z), std::abs(q.z), std::abs(r.z), std::abs(s.z)});
  const double mm = std::max({pp, qq, rr, ss});
  // The permanent is at most 24 mx my mz mm; 16 roundings of 2^-53 each, and those of the
  // differences.
  const double bound = 6e-14 * mx * my * mz * mm;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return ExactInSphere(a, b, c, d, e);
}

}  // namespace lsmvs::internal
