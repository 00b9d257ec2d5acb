#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct FairingOptions {
  // Faces whose normal is further than this (degrees) from the mean normal around them are crumbs:
  // pits, spikes and folds. The sides of a right-angled edge are at 45.
  double max_angle_deg = 70.0;
  // Crumbs that hang together in more faces than this are taken for the shape of the surface, such
  // as the side of a step.
  int max_faces = 16;
  int mean_rings = 3;      // reach of the mean normal, in rings of neighbours
  int num_rounds = 4;      // of looking for crumbs and smoothing them
  int num_iterations = 8;  // of smoothing in a round
};

// Smooths crumbs away: what noise leaves of a surface at the scale of its faces, and what motion
// along vertex normals cannot undo. Vertices of crumbs and their neighbours move towards the mean
// of their neighbours; all others, and those on a border, stay. The mean normal is the vector area
// of the patch around, which depends on the patch's rim alone, not on the crumbs in it. Faces that
// did not cross others do not after. Returns the number of vertices that moved. Deterministic for
// any number of threads. O(F) in a round.
size_t SmoothCrumbs(const FairingOptions& options, TriangleMesh* mesh, const RunContext& context);

}  // namespace lsmvs
