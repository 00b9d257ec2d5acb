#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/evaluation/mesh_renderer.h"
#include "lsmvs/geometry/posed_camera.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Direction that is up for whoever held the camera: the mean of the photos' upward axes. (0, -1, 0)
// without photos.
Eigen::Vector3d UpDirection(const std::vector<View>& views);

// Positions of the views in the order of their names.
std::vector<int> ViewsByName(const std::vector<View>& views);

// The photo that shows most sparse points; -1 without photos.
int MostRevealingView(const Scene& scene);

// The view's camera, reduced (or enlarged) to `width`.
PosedCamera ViewpointOf(const View& view, int width);

// The part of the mesh that the photos are about: its vertices in the box of the sparse points
// (without the outermost), a quarter larger. All vertices if that leaves hardly any, or without
// sparse points.
std::vector<Eigen::Vector3d> CentralVertices(const TriangleMesh& mesh, const Scene& scene);

// A turntable that begins where the photos were taken from.
TurntableOptions TurntableBefore(const std::vector<Eigen::Vector3d>& points,
                                 const std::vector<View>& views);

}  // namespace lsmvs
