#include "lsmvs/synthetic/revolution.h"

#include <cmath>
#include <numbers>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

// Vertices of one profile point: a ring, or one vertex on the axis.
struct Ring {
  int first = 0, count = 0;
  int At(int i) const { return first + i % count; }
};

Ring AddRing(const Eigen::Vector2d& point, int num_around, TriangleMesh* mesh) {
  const Ring ring{static_cast<int>(mesh->vertices.size()), point.x() > 0 ? num_around : 1};
  for (int i = 0; i < ring.count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / num_around;
    mesh->vertices.emplace_back(point.x() * std::cos(angle), point.x() * std::sin(angle),
                                point.y());
  }
  return ring;
}

void JoinRings(const Ring& low, const Ring& high, int num_around, TriangleMesh* mesh) {
  for (int i = 0; i < num_around; ++i) {
    if (low.count > 1) mesh->faces.emplace_back(low.At(i), low.At(i + 1), high.At(i));
    if (high.count > 1) mesh->faces.emplace_back(low.At(i + 1), high.At(i + 1), high.At(i));
  }
}

}  // namespace

TriangleMesh Revolve(const std::vector<Eigen::Vector2d>& profile, bool closed_profile,
                     int num_around) {
  LSMVS_CHECK_GE(num_around, 3);
  TriangleMesh mesh;
  std::vector<Ring> rings;
  for (const Eigen::Vector2d& point : profile) rings.push_back(AddRing(point, num_around, &mesh));
  for (size_t i = 0; i + 1 < rings.size(); ++i) {
    JoinRings(rings[i], rings[i + 1], num_around, &mesh);
  }
  if (closed_profile) JoinRings(rings.back(), rings.front(), num_around, &mesh);
  return mesh;
}

}  // namespace lsmvs
