#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// What a pinhole camera sees of a triangle mesh, at the centres of its pixels.
struct SurfaceMaps {
  Raster<float> depth;   // z in the camera frame, world units; 0 where the camera sees nothing
  Raster<int32_t> face;  // index of the nearest face; -1 where there is none
};

struct RasterizerOptions {
  // Leave out faces that the camera sees from behind (clockwise in the image).
  bool cull_back_faces = false;
};

// Z-buffer of triangles: #V vertices in the world, #F faces of indices into them. A pixel belongs
// to a face if its centre lies inside the projected triangle or on its left or top edge, so that
// neighbours neither overlap nor leave a gap. Of several faces the nearest wins, of equally near
// ones the lowest index. Depth is that of the face's plane (perspective correct). Parts of faces
// behind the camera are clipped. `maps` is resized to the camera's image; its memory is reused.
// Runs on the calling thread. O(#V + #F + pixels); 32 bytes a vertex of scratch.
void RasterizeMesh(const PinholeCamera& camera, const Rigid3& cam_from_world,
                   std::span<const Eigen::Vector3d> vertices,
                   std::span<const Eigen::Vector3i> faces, const RasterizerOptions& options,
                   SurfaceMaps* maps);

}  // namespace lsmvs
