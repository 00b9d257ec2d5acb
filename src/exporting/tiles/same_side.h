#pragma once

#include <Eigen/Core>
#include <optional>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// The point of a mesh that a point of another surface of the same object stands for: the nearest
// one, unless that lies on a face that looks the other way (the back of a thin wall); then the
// nearest along the normal, to both sides and within `reach`, on a face that looks the same way, if
// there is one. `tracer` is that of `mesh`. Empty for a mesh without faces.
std::optional<ClosestPoint> ClosestOnSameSide(const MeshTracer& tracer, const TriangleMesh& mesh,
                                              const Eigen::Vector3d& x,
                                              const Eigen::Vector3d& normal, double reach);

}  // namespace lsmvs
