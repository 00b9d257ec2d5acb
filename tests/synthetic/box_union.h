#pragma once

#include <array>
#include <memory>
#include <vector>

#include "lsmvs/synthetic/mesh_shape.h"
#include "lsmvs/synthetic/shape.h"

namespace lsmvs {

// Union of axis-parallel boxes: one box, steps, walls, buildings. Boxes may overlap and touch along
// faces, but must not touch along an edge or a corner only (the surface would not be manifold).
// Distances are exact inside too. Intersect is O(#boxes), Closest O(log #sides).
class BoxUnion : public Shape {
 public:
  explicit BoxUnion(std::vector<Eigen::AlignedBox3d> boxes);

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  TriangleMesh Mesh(double edge_length) const override;

 private:
  // One side of a cell of the grid that the boxes' faces span, between an occupied and an empty
  // cell.
  struct BoundarySide {
    Eigen::Vector3i cell;  // the occupied one
    int axis;
    bool positive;  // faces the positive direction of the axis
  };
  bool Contains(const Eigen::Vector3d& x) const;
  void FillGrid();
  bool Occupied(const Eigen::Vector3i& cell) const;
  std::vector<BoundarySide> Boundary() const;

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::array<std::vector<double>, 3> cuts_;  // distinct coordinates of the boxes' faces, ascending
  std::vector<bool> occupied_;               // cells between the cuts, x fastest
  std::unique_ptr<const MeshShape> boundary_;
};

}  // namespace lsmvs
