#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <limits>

#include "lsmvs/surface/cell_complex.h"

namespace lsmvs {

// Walks along rays that start at a vertex, from cell to cell.
//
// Every vertex met is projected once along the ray to a pair of floats; on which side the ray
// passes an edge is the sign of a 2x2 determinant of such pairs, whose products are exact in double
// precision. So all decisions of one walk agree with one (slightly moved) projection of the
// vertices: each triangle that is entered has exactly one way out of the next cell, walks cannot
// branch or loop, and they end in the cell that holds the target or outside of the hull. A ray that
// hits an edge or a vertex exactly is moved by an infinitesimal tilt, the same in all tests of the
// walk.
class RayWalker {
 public:
  struct End {
    int32_t cell = -1;  // the cell that holds the ray's end, or the cell at infinity through which
                        // it left; -1: lost
    uint32_t num_crossings = 0;
  };

  explicit RayWalker(const CellComplex& complex) : complex_(complex) {}

  // Calls on_cross(cell, facet, distance) for each facet that the segment of `length` from `vertex`
  // in `direction` (unit length) crosses, with the cell that is *entered* and the facet in it.
  // `distance` from the vertex is exact up to rounding below near_distance, and not less than
  // near_distance beyond.
  template <class OnCross>
  End Walk(int32_t vertex, const Eigen::Vector3d& direction, double length, double near_distance,
           const OnCross& on_cross);

 private:
  // A vertex in the frame of the ray: z along it.
  struct Projected {
    int32_t vertex = 0;
    float x = 0, y = 0, z = 0;
  };

  void SetFrame(int32_t vertex, const Eigen::Vector3d& direction);
  Projected Project(int32_t vertex) const {
    const Eigen::Vector3f& p = complex_.points[vertex];
    const double dx = p.x() - origin_[0], dy = p.y() - origin_[1], dz = p.z() - origin_[2];
    return {vertex, static_cast<float>(u_[0] * dx + u_[1] * dy + u_[2] * dz),
            static_cast<float>(v_[0] * dx + v_[1] * dy + v_[2] * dz),
            static_cast<float>(w_[0] * dx + w_[1] * dy + w_[2] * dz)};
  }
  // Whether b lies counter-clockwise of a seen against the ray, ties broken by tilting the ray.
  static bool TurnsLeft(const Projected& a, const Projected& b) {
    const double left = static_cast<double>(a.x) * b.y, right = static_cast<double>(a.y) * b.x;
    if (left != right) [[likely]]
      return left > right;
    return TurnsLeftTilted(a, b);
  }
  static bool TurnsLeftTilted(const Projected& a, const Projected& b);
  // Where the ray crosses the triangle.
  static double Depth(const Projected& a, const Projected& b, const Projected& c);
  // Finds the cell around `vertex` into which the ray starts and the facet (a, b, c),
  // counter-clockwise seen from outside of that cell, through which it leaves it. -1: not found; a
  // cell at infinity: the ray starts outside of the hull.
  int32_t FindStart(int32_t vertex, Projected* a, Projected* b, Projected* c, int* exit) const;

  const CellComplex& complex_;
  Eigen::Vector3d origin_, u_, v_, w_;
};

inline void RayWalker::SetFrame(int32_t vertex, const Eigen::Vector3d& direction) {
  origin_ = complex_.points[vertex].cast<double>();
  w_ = direction;
  // T. Duff et al.: Building an orthonormal basis, revisited, JCGT 6(1), 2017.
  const double sign = std::copysign(1.0, w_.z());
  const double a = -1.0 / (sign + w_.z()), b = w_.x() * w_.y() * a;
  u_ = {1.0 + sign * w_.x() * w_.x() * a, sign * b, -sign * w_.x()};
  v_ = {b, sign + w_.y() * w_.y() * a, -w_.y()};
}

inline double RayWalker::Depth(const Projected& a, const Projected& b, const Projected& c) {
  const auto turn = [](const Projected& p, const Projected& q) {
    return static_cast<double>(p.x) * q.y - static_cast<double>(p.y) * q.x;
  };
  const double wa = turn(b, c), wb = turn(c, a), wc = turn(a, b);
  const double sum = wa + wb + wc;
  if (sum <= 0) return std::min({a.z, b.z, c.z});
  return (wa * a.z + wb * b.z + wc * c.z) / sum;
}

template <class OnCross>
RayWalker::End RayWalker::Walk(int32_t vertex, const Eigen::Vector3d& direction, double length,
                               double near_distance, const OnCross& on_cross) {
  SetFrame(vertex, direction);
  Projected a, b, c;
  int exit = 0;
  int32_t current = FindStart(vertex, &a, &b, &c, &exit);
  End end{current, 0};
  const float near = static_cast<float>(near_distance), far = static_cast<float>(length);
  while (current >= 0 && !complex_.IsInfinite(current)) {
    const float lowest = std::min({a.z, b.z, c.z}), highest = std::max({a.z, b.z, c.z});
    double distance = lowest;
    if (lowest < near || highest >= far) {
      distance = Depth(a, b, c);
      if (distance >= length) break;
    }
    const Cell& left = complex_.cells[current];
    const int32_t next = left.neighbor[exit];
    const int entry = left.Reverse(exit);
    on_cross(next, entry, distance);
    ++end.num_crossings;
    current = next;
    end.cell = current;
    if (complex_.IsInfinite(current)) break;
    const Cell& cell = complex_.cells[current];
    const Projected d = Project(cell.vertex[entry]);
    // One of (a, b, d), (b, c, d), (c, a, d) is crossed: replace the third by d.
    Projected* replaced;
    if (TurnsLeft(b, d)) {
      replaced = TurnsLeft(a, d) ? &b : &c;
    } else {
      replaced = TurnsLeft(c, d) ? &a : &b;
    }
    exit = cell.IndexOfVertex(replaced->vertex);
    *replaced = d;
  }
  return end;
}

}  // namespace lsmvs
