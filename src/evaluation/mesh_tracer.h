#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Where a ray meets a mesh first.
struct MeshHit {
  double distance = 0;                         // in lengths of the ray's direction
  int face = -1;                               // position in TriangleMesh::faces
  float barycentric_1 = 0, barycentric_2 = 0;  // weights of the face's second and third vertex
};

// The point of a mesh that is nearest to another.
struct ClosestPoint {
  double distance = 0;
  int face = -1;
  Eigen::Vector3d x_in_world = Eigen::Vector3d::Zero();
};

// Answers ray and closest-point questions about a mesh. Holds its own copy of it, in single
// precision about the middle of its bounding box: distances are right to about 1e-7 of the mesh's
// size. Faces with vertices that are not finite are left out. Both sides of a face are seen.
// Queries are thread-safe, and give the same answer on any number of threads. Building takes O(F
// log F) and about 150 bytes per face. Embree (Wald et al., SIGGRAPH 2014).
class MeshTracer {
 public:
  MeshTracer(const TriangleMesh& mesh, const RunContext& context);
  ~MeshTracer();
  MeshTracer(const MeshTracer&) = delete;
  MeshTracer& operator=(const MeshTracer&) = delete;

  size_t num_faces() const;     // that are traced
  size_t num_left_out() const;  // with vertices that are not finite

  // `direction` need not be of unit length. Hits nearer than `begin` or farther than `end` (in
  // lengths of the direction) do not count.
  std::optional<MeshHit> Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                              double begin = 0,
                              double end = std::numeric_limits<double>::infinity()) const;
  // Whether anything lies on the ray between `begin` and `end`; faster than Cast.
  bool Occluded(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double begin,
                double end) const;
  // Empty if nothing is nearer than `max_distance`.
  std::optional<ClosestPoint> Closest(
      const Eigen::Vector3d& x_in_world,
      double max_distance = std::numeric_limits<double>::infinity()) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Depth (z in the camera frame) at the pixel centres of a camera; 0 where no face is seen.
Raster<float> TraceDepth(const MeshTracer& tracer, const PinholeCamera& camera,
                         const Rigid3& cam_from_world, const RunContext& context);

}  // namespace lsmvs
