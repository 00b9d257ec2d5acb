#include "lsmvs/synthetic/analytic_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "lsmvs/synthetic/revolution.h"

namespace lsmvs {

namespace {

constexpr double kPi = std::numbers::pi;
// Around a circle: the chords stay within 2 % of the radius.
constexpr int kMinStepsAround = 16;

// Distance to the sphere along the ray, from outside.
std::optional<double> SphereDistance(const Eigen::Vector3d& origin_from_center,
                                     const Eigen::Vector3d& direction, double radius) {
  const double along = origin_from_center.dot(direction);
  const double across_squared = (origin_from_center - along * direction).squaredNorm();
  const double half_chord_squared = radius * radius - across_squared;
  if (half_chord_squared < 0) return std::nullopt;
  const double distance = -along - std::sqrt(half_chord_squared);
  if (distance < 0) return std::nullopt;
  return distance;
}

// Unit vector of `v`, or `fallback` where it has no direction.
Eigen::Vector3d UnitOr(const Eigen::Vector3d& v, const Eigen::Vector3d& fallback) {
  const double length = v.norm();
  return length > 0 ? Eigen::Vector3d(v / length) : fallback;
}

// Point of a surface at `radius` around its skeleton.
SurfacePoint AroundSkeleton(const Eigen::Vector3d& x, const Eigen::Vector3d& skeleton,
                            double radius, const Eigen::Vector3d& fallback) {
  const Eigen::Vector3d normal = UnitOr(x - skeleton, fallback);
  return {skeleton + radius * normal, normal, (x - skeleton).norm() - radius};
}

int Steps(double length, double edge_length, int min_steps) {
  return std::max(min_steps, static_cast<int>(std::ceil(length / edge_length)));
}

TriangleMesh Icosahedron() {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  TriangleMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Eigen::Vector3d& x : mesh.vertices) x.normalize();
  return mesh;
}

// Splits every face of a mesh on the unit sphere into four.
TriangleMesh SplitOnUnitSphere(const TriangleMesh& mesh) {
  TriangleMesh split;
  split.vertices = mesh.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(split.vertices.size()));
    if (is_new) split.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
    return entry->second;
  };
  for (const Eigen::Vector3i& f : mesh.faces) {
    const int ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
    split.faces.insert(split.faces.end(),
                       {{f[0], ab, ca}, {f[1], bc, ab}, {f[2], ca, bc}, {ab, bc, ca}});
  }
  return split;
}

}  // namespace

std::optional<RayHit> Sphere::Intersect(const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction) const {
  const auto distance = SphereDistance(origin - center_, direction, radius_);
  if (!distance) return std::nullopt;
  return RayHit{*distance, (origin + *distance * direction - center_) / radius_};
}

SurfacePoint Sphere::Closest(const Eigen::Vector3d& x) const {
  return AroundSkeleton(x, center_, radius_, Eigen::Vector3d::UnitZ());
}

Eigen::AlignedBox3d Sphere::Bounds() const {
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(radius_);
  return {center_ - half, center_ + half};
}

TriangleMesh Sphere::Mesh(double edge_length) const {
  TriangleMesh mesh = Icosahedron();
  // Edges of the icosahedron are 1.0515 long; middle ones of a split are up to 1.18 times half of
  // their parent.
  for (double edge = 1.0515 * radius_; edge > edge_length; edge *= 0.56) {
    mesh = SplitOnUnitSphere(mesh);
  }
  for (Eigen::Vector3d& x : mesh.vertices) x = center_ + radius_ * x;
  return mesh;
}

std::optional<RayHit> Torus::Intersect(const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) const {
  // Sphere tracing (Hart, The Visual Computer 1996) inside the bounding sphere.
  const double outer = major_radius_ + minor_radius_;
  const double middle = (center_ - origin).dot(direction);
  const double across_squared = (center_ - origin - middle * direction).squaredNorm();
  if (across_squared > outer * outer) return std::nullopt;
  const double half_chord = std::sqrt(outer * outer - across_squared);
  double distance = std::max(0.0, middle - half_chord);
  constexpr int kMaxSteps = 10000;
  for (int i = 0; i < kMaxSteps && distance <= middle + half_chord; ++i) {
    const SurfacePoint closest = Closest(origin + distance * direction);
    if (closest.signed_distance < 1e-12 * outer) return RayHit{distance, closest.normal};
    distance += closest.signed_distance;
  }
  return std::nullopt;
}

SurfacePoint Torus::Closest(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d flat(x.x() - center_.x(), x.y() - center_.y(), 0.0);
  const Eigen::Vector3d on_ring = center_ + major_radius_ * UnitOr(flat, Eigen::Vector3d::UnitX());
  return AroundSkeleton(x, on_ring, minor_radius_, Eigen::Vector3d::UnitZ());
}

Eigen::AlignedBox3d Torus::Bounds() const {
  const double outer = major_radius_ + minor_radius_;
  const Eigen::Vector3d half(outer, outer, minor_radius_);
  return {center_ - half, center_ + half};
}

TriangleMesh Torus::Mesh(double edge_length) const {
  const int num_tube = Steps(2 * kPi * minor_radius_, edge_length, kMinStepsAround);
  const int num_around =
      Steps(2 * kPi * (major_radius_ + minor_radius_), edge_length, kMinStepsAround);
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i < num_tube; ++i) {
    const double angle = 2 * kPi * i / num_tube;
    profile.emplace_back(major_radius_ + minor_radius_ * std::cos(angle),
                         minor_radius_ * std::sin(angle));
  }
  TriangleMesh mesh = Revolve(profile, true, num_around);
  for (Eigen::Vector3d& x : mesh.vertices) x += center_;
  return mesh;
}

std::optional<RayHit> Capsule::Intersect(const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction) const {
  std::optional<double> nearest;
  const auto consider = [&](std::optional<double> distance) {
    if (distance && (!nearest || *distance < *nearest)) nearest = distance;
  };
  consider(SphereDistance(origin - a_, direction, radius_));
  consider(SphereDistance(origin - b_, direction, radius_));
  const Eigen::Vector3d axis = (b_ - a_).normalized();
  const Eigen::Vector3d across = direction - direction.dot(axis) * axis;
  const double sine = across.norm();
  if (sine > 0) {
    // In the plane across the axis the cylinder is a circle.
    const Eigen::Vector3d from_a = origin - a_;
    const auto flat =
        SphereDistance(from_a - from_a.dot(axis) * axis, Eigen::Vector3d(across / sine), radius_);
    if (flat) {
      const double distance = *flat / sine;
      const double along = (from_a + distance * direction).dot(axis);
      if (along >= 0 && along <= (b_ - a_).norm()) consider(distance);
    }
  }
  if (!nearest) return std::nullopt;
  return RayHit{*nearest, Closest(origin + *nearest * direction).normal};
}

SurfacePoint Capsule::Closest(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d ab = b_ - a_;
  const double along = std::clamp((x - a_).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return AroundSkeleton(x, a_ + along * ab, radius_, ab.unitOrthogonal());
}

Eigen::AlignedBox3d Capsule::Bounds() const {
  Eigen::AlignedBox3d box(a_.cwiseMin(b_), a_.cwiseMax(b_));
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(radius_);
  return {box.min() - half, box.max() + half};
}

TriangleMesh Capsule::Mesh(double edge_length) const {
  const double length = (b_ - a_).norm();
  const int num_arc = Steps(0.5 * kPi * radius_, edge_length, kMinStepsAround / 4);
  const int num_body = Steps(length, edge_length, 1);
  std::vector<Eigen::Vector2d> profile;
  const auto add_arc = [&](double middle, double begin) {
    for (int i = 0; i <= num_arc; ++i) {
      const double angle = begin + 0.5 * kPi * i / num_arc;
      const bool on_axis = (begin < 0 && i == 0) || (begin >= 0 && i == num_arc);
      profile.emplace_back(on_axis ? 0.0 : radius_ * std::cos(angle),
                           middle + radius_ * std::sin(angle));
    }
  };
  add_arc(0.0, -0.5 * kPi);
  for (int i = 1; i < num_body; ++i) profile.emplace_back(radius_, length * i / num_body);
  add_arc(length, 0.0);
  TriangleMesh mesh =
      Revolve(profile, false, Steps(2 * kPi * radius_, edge_length, kMinStepsAround));
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), b_ - a_).toRotationMatrix();
  for (Eigen::Vector3d& x : mesh.vertices) x = a_ + turn * x;
  return mesh;
}

}  // namespace lsmvs
