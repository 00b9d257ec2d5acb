#include "lsmvs/synthetic/mesh_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr uint32_t kLeafFaces = 4;
constexpr int kMaxDepth = 64;

// Distance at which the ray enters the box, or infinity if it misses it or enters after `limit`.
double EnterBox(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin,
                const Eigen::Vector3d& inverse_direction, double limit) {
  double enter = 0, leave = limit;
  for (int k = 0; k < 3; ++k) {
    const bool forward = inverse_direction[k] >= 0;
    const double near_plane = forward ? box.min()[k] : box.max()[k];
    const double far_plane = forward ? box.max()[k] : box.min()[k];
    // Argument order matters: NaN (a ray within a side's plane) cuts nothing off.
    enter = std::max(enter, (near_plane - origin[k]) * inverse_direction[k]);
    leave = std::min(leave, (far_plane - origin[k]) * inverse_direction[k]);
  }
  // A little slack keeps rays in the plane of a flat box.
  return enter <= leave * (1 + 1e-12) + 1e-300 ? enter : std::numeric_limits<double>::infinity();
}

// Distance to the triangle along the ray (Moeller and Trumbore 1997), or a negative value. Edges
// belong to both their triangles, so that no ray slips through.
double HitTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  constexpr double kSlack = 1e-10;
  const Eigen::Vector3d ab = b - a, ac = c - a, p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0) return -1;
  const Eigen::Vector3d from_a = origin - a;
  const double u = from_a.dot(p) / determinant;
  if (!(u >= -kSlack && u <= 1 + kSlack)) return -1;
  const Eigen::Vector3d q = from_a.cross(ab);
  const double v = direction.dot(q) / determinant;
  if (!(v >= -kSlack && u + v <= 1 + kSlack)) return -1;
  return ac.dot(q) / determinant;
}

Eigen::Vector3d ClosestOnSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& x) {
  const Eigen::Vector3d ab = b - a;
  const double length_squared = ab.squaredNorm();
  if (length_squared == 0) return a;
  return a + std::clamp((x - a).dot(ab) / length_squared, 0.0, 1.0) * ab;
}

// The foot of the perpendicular if it lies inside, else the best of the three edges.
Eigen::Vector3d ClosestOnTriangle(const std::array<Eigen::Vector3d, 3>& corners,
                                  const Eigen::Vector3d& x) {
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  bool inside = normal.squaredNorm() > 0;
  for (int k = 0; k < 3 && inside; ++k) {
    const Eigen::Vector3d& a = corners[k];
    inside = (corners[(k + 1) % 3] - a).cross(x - a).dot(normal) >= 0;
  }
  if (inside) return x - normal * ((x - corners[0]).dot(normal) / normal.squaredNorm());
  Eigen::Vector3d best = ClosestOnSegment(corners[0], corners[1], x);
  for (int k = 1; k < 3; ++k) {
    const Eigen::Vector3d other = ClosestOnSegment(corners[k], corners[(k + 1) % 3], x);
    if ((other - x).squaredNorm() < (best - x).squaredNorm()) best = other;
  }
  return best;
}

}  // namespace

MeshShape::MeshShape(TriangleMesh mesh) : mesh_(std::move(mesh)) {
  LSMVS_CHECK(!mesh_.faces.empty());
  const auto count = static_cast<uint32_t>(mesh_.faces.size());
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<Eigen::Vector3d> centroids;
  for (uint32_t f = 0; f < count; ++f) centroids.push_back(FaceBox(f).center());
  nodes_.emplace_back();
  Build(0, 0, count, centroids);
}

Eigen::AlignedBox3d MeshShape::FaceBox(uint32_t face) const {
  Eigen::AlignedBox3d box;
  for (const int v : mesh_.faces[face]) box.extend(mesh_.vertices[v]);
  return box;
}

void MeshShape::Build(uint32_t node, uint32_t first, uint32_t count,
                      const std::vector<Eigen::Vector3d>& centroids) {
  Eigen::AlignedBox3d box, centroid_box;
  for (uint32_t i = first; i < first + count; ++i) {
    box.extend(FaceBox(order_[i]));
    centroid_box.extend(centroids[order_[i]]);
  }
  if (count <= kLeafFaces) {
    nodes_[node] = {box, first, count};
    return;
  }
  int axis = 0;
  centroid_box.sizes().maxCoeff(&axis);
  const uint32_t half = count / 2;
  std::nth_element(order_.begin() + first, order_.begin() + first + half,
                   order_.begin() + first + count, [&](uint32_t a, uint32_t b) {
                     const double x = centroids[a][axis], y = centroids[b][axis];
                     return x != y ? x < y : a < b;
                   });
  const auto left = static_cast<uint32_t>(nodes_.size());
  nodes_[node] = {box, left, 0};
  nodes_.resize(nodes_.size() + 2);
  Build(left, first, half, centroids);
  Build(left + 1, first + half, count - half, centroids);
}

std::optional<RayHit> MeshShape::Intersect(const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d inverse = direction.cwiseInverse();
  double nearest = std::numeric_limits<double>::infinity();
  uint32_t hit_face = 0;
  std::array<std::pair<uint32_t, double>, kMaxDepth> stack;
  int size = 0;
  const auto push = [&](uint32_t node, double enter) {
    if (enter < nearest) stack[size++] = {node, enter};
  };
  push(0, EnterBox(nodes_[0].box, origin, inverse, nearest));
  while (size > 0) {
    const auto [index, enter] = stack[--size];
    if (enter >= nearest) continue;
    const Node& node = nodes_[index];
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Eigen::Vector3i& f = mesh_.faces[order_[i]];
      const double distance = HitTriangle(mesh_.vertices[f[0]], mesh_.vertices[f[1]],
                                          mesh_.vertices[f[2]], origin, direction);
      if (distance >= 0 && distance < nearest) {
        nearest = distance;
        hit_face = order_[i];
      }
    }
    if (node.count > 0) continue;
    const double left = EnterBox(nodes_[node.first].box, origin, inverse, nearest);
    const double right = EnterBox(nodes_[node.first + 1].box, origin, inverse, nearest);
    const bool left_first = left <= right;
    push(node.first + (left_first ? 1 : 0), left_first ? right : left);
    push(node.first + (left_first ? 0 : 1), left_first ? left : right);
  }
  if (std::isinf(nearest)) return std::nullopt;
  return RayHit{nearest, FaceNormalTimesTwiceArea(mesh_, hit_face).normalized()};
}

SurfacePoint MeshShape::Closest(const Eigen::Vector3d& x) const {
  double nearest = std::numeric_limits<double>::infinity();
  double nearest_height = 0;
  SurfacePoint result;
  std::array<std::pair<uint32_t, double>, kMaxDepth> stack;
  int size = 0;
  stack[size++] = {0, 0.0};
  while (size > 0) {
    const auto [index, bound] = stack[--size];
    if (bound > nearest) continue;
    const Node& node = nodes_[index];
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Eigen::Vector3i& f = mesh_.faces[order_[i]];
      const Eigen::Vector3d point =
          ClosestOnTriangle({mesh_.vertices[f[0]], mesh_.vertices[f[1]], mesh_.vertices[f[2]]}, x);
      const double squared = (point - x).squaredNorm();
      if (squared > nearest * (1 + 1e-12)) continue;
      const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, order_[i]).normalized();
      const double height = (x - point).dot(normal);
      // Of the faces that meet at an edge, the one that x is farthest above or below decides on the
      // sign.
      const bool nearer = squared < nearest * (1 - 1e-12);
      if (!nearer && std::abs(height) <= std::abs(nearest_height)) continue;
      nearest = squared;
      nearest_height = height;
      result = {point, normal, std::copysign(std::sqrt(squared), height)};
    }
    if (node.count > 0) continue;
    const double left = nodes_[node.first].box.squaredExteriorDistance(x);
    const double right = nodes_[node.first + 1].box.squaredExteriorDistance(x);
    const bool left_first = left <= right;
    stack[size++] = {node.first + (left_first ? 1 : 0), left_first ? right : left};
    stack[size++] = {node.first + (left_first ? 0 : 1), left_first ? left : right};
  }
  return result;
}

Eigen::AlignedBox3d MeshShape::Bounds() const { return nodes_[0].box; }

TriangleMesh MeshShape::Mesh(double /*edge_length*/) const { return mesh_; }

}  // namespace lsmvs
