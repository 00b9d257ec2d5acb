#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "lsmvs/surface/tetrahedralization.h"

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
    int32_t cell = -1;  // that holds the ray's end, or at infinity through which it left; -1: lost
    uint32_t num_crossings = 0;
  };
  // A vertex in the frame of the ray: z along it.
  struct Projected {
    Eigen::Vector4f x;  // x, y, z; the fourth means nothing
    int32_t vertex = 0;
  };
  // A ray on its way. Several of them, stepped in turn, hide each other's memory latency.
  struct Ray {
    Eigen::Vector4f origin;
    std::array<Eigen::Vector4f, 3>
        axes;  // what a step along x, y, z of the world is in the ray's frame
    std::array<Projected, 3> corners;  // of the facet that is crossed next, counter-clockwise
    int32_t current = -1, next = -1;   // the cells before and behind it
    int32_t exit = 0, entry = 0;       // the facet between them, in each
    uint32_t num_crossings = 0;
    float near = 0, length = 0;
    bool careful = true;  // near one of the ends: distances matter
  };

  // Copies the points: 16 bytes each.
  explicit RayWalker(const Tetrahedralization& complex);

  // Asks for the memory that Start will read, some calls ahead of it.
  void Prefetch(int32_t vertex) const {
    const int32_t cell = complex_.incident_cell[vertex];
    if (cell >= 0) __builtin_prefetch(&complex_.cells[cell]);
  }
  // Sets off from `vertex` in `direction` (unit length). False if the ray ends at once: see EndOf.
  bool Start(int32_t vertex, const Eigen::Vector3d& direction, double length, double near_distance,
             Ray* ray) const;
  // Crosses the next facet and calls on_cross(cell, facet, distance) with the cell that is
  // *entered*, the facet in it and the distance from the vertex, which is exact up to rounding
  // below near_distance and not less than near_distance beyond. False at the end.
  template <class OnCross>
  bool Step(Ray* ray, const OnCross& on_cross) const;
  End EndOf(const Ray& ray) const { return {ray.current, ray.num_crossings}; }

  // From start to end.
  template <class OnCross>
  End Walk(int32_t vertex, const Eigen::Vector3d& direction, double length, double near_distance,
           const OnCross& on_cross) const {
    Ray ray;
    bool going = Start(vertex, direction, length, near_distance, &ray);
    while (going) going = Step(&ray, on_cross);
    return EndOf(ray);
  }

 private:
  // Single precision moves far vertices sideways by 1e-7 of their distance at most, the same for
  // all cells they belong to.
  Projected Project(const Ray& ray, int32_t vertex) const {
    const Eigen::Vector4f d = points_[vertex] - ray.origin;
    return {ray.axes[0] * d[0] + ray.axes[1] * d[1] + ray.axes[2] * d[2], vertex};
  }
  // Whether b lies counter-clockwise of a seen against the ray, ties broken by tilting the ray.
  static bool TurnsLeft(const Projected& a, const Projected& b) {
    const double left = static_cast<double>(a.x[0]) * b.x[1];
    const double right = static_cast<double>(a.x[1]) * b.x[0];
    if (left == right) [[unlikely]]
      return TurnsLeftTilted(a, b);
    return left > right;
  }
  static bool TurnsLeftTilted(const Projected& a, const Projected& b);
  // Where the ray crosses the triangle.
  static double Depth(const std::array<Projected, 3>& corners);
  // Finds the cell around `vertex` into which the ray starts, and the facet through which it leaves
  // it, which becomes the ray's corners; returns its index. -1: there is none, the ray ends at
  // once.
  int FindStart(int32_t vertex, Ray* ray) const;
  void LeaveThrough(int exit, Ray* ray) const {
    const Cell& cell = complex_.cells[ray->current];
    ray->exit = exit;
    ray->next = cell.neighbor[exit];
    ray->entry = cell.Reverse(exit);
    __builtin_prefetch(&complex_.cells[ray->next]);
  }

  const Tetrahedralization& complex_;
  std::vector<Eigen::Vector4f> points_;
};

template <class OnCross>
bool RayWalker::Step(Ray* ray, const OnCross& on_cross) const {
  auto& corners = ray->corners;
  double distance = ray->near;
  if (ray->careful) {
    distance = Depth(corners);
    if (distance >= ray->length) return false;
    const auto beyond = [&](const Projected& corner) { return corner.x[2] >= ray->length; };
    ray->careful = distance < ray->near || std::any_of(corners.begin(), corners.end(), beyond);
  }
  on_cross(ray->next, ray->entry, distance);
  ++ray->num_crossings;
  ray->current = ray->next;
  if (complex_.IsInfinite(ray->current)) return false;
  const Cell& cell = complex_.cells[ray->current];
  const Projected d = Project(*ray, cell.vertex[ray->entry]);
  // The way out is (a, b, d), (b, c, d) or (c, a, d): the third corner is replaced by d. Without
  // branches, as nobody can predict them.
  constexpr std::array<uint8_t, 4> kReplaced = {1, 0, 2, 1};
  const unsigned left_of_b = TurnsLeft(corners[1], d);
  const unsigned left_of_other = TurnsLeft(corners[2 - 2 * left_of_b], d);
  if (d.x[2] >= ray->length) [[unlikely]]
    ray->careful = true;
  Projected& replaced = corners[kReplaced[2 * left_of_b + left_of_other]];
  const int32_t dropped = replaced.vertex;
  replaced = d;
  LeaveThrough((cell.vertex[1] == dropped) + 2 * (cell.vertex[2] == dropped) +
                   3 * (cell.vertex[3] == dropped),
               ray);
  return true;
}

}  // namespace lsmvs
