#pragma once

#include <vector>

#include "lsmvs/synthetic/shape.h"

namespace lsmvs {

// A triangle mesh as truth: exact for rays and closest points, through a bounding volume hierarchy
// in double precision. O(F log F) to build, O(log F) a query where triangles are spread evenly. The
// sign of the distance comes from the closest face: right for closed meshes away from sharp edges,
// meaningless for open ones (take the absolute value).
class MeshShape : public Shape {
 public:
  explicit MeshShape(TriangleMesh mesh);

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  // The mesh itself, whatever the length of its edges.
  TriangleMesh Mesh(double edge_length) const override;

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    uint32_t first = 0,
             count =
                 0;  // of order_; count 0: an inner node whose children are `first` and `first` + 1
  };
  void Build(uint32_t node, uint32_t first, uint32_t count,
             const std::vector<Eigen::Vector3d>& centroids);
  Eigen::AlignedBox3d FaceBox(uint32_t face) const;

  TriangleMesh mesh_;
  std::vector<uint32_t> order_;  // faces, grouped by leaf
  std::vector<Node> nodes_;
};

}  // namespace lsmvs
