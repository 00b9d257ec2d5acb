#pragma once

#include <vector>

#include "lsmvs/synthetic/shape.h"

namespace lsmvs {

// Union of axis-parallel boxes: one box, steps, walls, buildings. Boxes may overlap and touch along
// faces, but must not touch along an edge or a corner only (the surface would not be manifold).
// Distances are exact inside too. Intersect is O(#boxes), Closest O(#rectangles of the boundary).
class BoxUnion : public Shape {
 public:
  explicit BoxUnion(std::vector<Eigen::AlignedBox3d> boxes);

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  TriangleMesh Mesh(double edge_length) const override;

 private:
  // Part of the boundary: flat along `axis`, facing its positive or negative direction.
  struct Rectangle {
    Eigen::AlignedBox3d box;
    int axis;
    double sign;
  };
  bool Contains(const Eigen::Vector3d& x) const;
  void FindBoundary();
  // Cuts each gap of a sorted list of coordinates into equal parts of at most `edge_length`.
  static std::vector<double> Subdivide(const std::vector<double>& cuts, double edge_length);

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<double> cuts_[3];  // distinct coordinates of the boxes' faces
  std::vector<Rectangle> boundary_;
};

}  // namespace lsmvs
