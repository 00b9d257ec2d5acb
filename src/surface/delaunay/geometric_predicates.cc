#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "lsmvs/surface/delaunay/geometric_predicates.h"

namespace lsmvs::internal {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 ToPoint(const Eigen::Vector3f& x) { return {x.x(), x.y(), x.z()}; }

}  // namespace

int ExactOrientation(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                     const Eigen::Vector3f& d) {
  return CGAL::orientation(ToPoint(a), ToPoint(b), ToPoint(c), ToPoint(d));
}

int ExactInSphere(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                  const Eigen::Vector3f& d, const Eigen::Vector3f& e) {
  return CGAL::side_of_oriented_sphere(ToPoint(a), ToPoint(b), ToPoint(c), ToPoint(d), ToPoint(e));
}

}  // namespace lsmvs::internal
