#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "lsmvs/merging/overlap/mesh_band.h"
#include "lsmvs/merging/overlap/overlap.h"
#include "lsmvs/merging/seam/conflicts.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SurfaceMergingOptions {
  // Edge lengths within which two surfaces are taken for the same one.
  double max_edges = 6;
  // Which mesh is right where both contradict each other; empty: the first.
  ConflictWorth worth;
  // Given a mesh and the other: which vertices of the first stand in space that the second's views
  // saw empty. May be empty.
  std::function<std::vector<uint8_t>(const SourcedMesh&, const SourcedMesh&)> in_free_space;
  // Edge lengths that the seam keeps from where a mesh ends.
  double inset = 3;
};

// A place where two meshes contradict each other, and which one is right there.
struct ConflictPoint {
  Eigen::Vector3d position;  // of a vertex
  bool of_first = true;      // whose vertex it is
  bool first_wins = true;

  bool IsLost() const { return of_first != first_wins; }
};

struct SurfaceMergingCounters {
  size_t num_dropped_faces = 0;   // of both, of the overlap
  size_t num_new_faces = 0;       // of the seam
  size_t num_open_edges = 0;      // of the seam, that found no partner
  size_t num_crossings = 0;       // pairs of faces at the seam that cross
  size_t num_conflict_faces = 0;  // of both
  // Where the meshes contradict each other or were not joined.
  std::vector<Eigen::Vector3d> trouble;
  std::vector<ConflictPoint> conflicts;  // vertices of both
};

// Joins two meshes that agree where they overlap, along a seam (thesis, 5.2.3). Each face of the
// overlap is kept of one mesh only, by a minimum cut on the first surface: each mesh where it is
// alone, else the finer one, with a seam that is short and runs where the surfaces are close. The
// coarser mesh is split towards the seam until its edges are as long as the other's; both surfaces
// are moved together in a band around the seam; the gap is filled with triangles; and where faces
// cross there, vertices of the band are smoothed. Vertices farther from the seam keep their bytes
// and their order, the first mesh's before the second's. Memory: about 600 bytes a face within
// some edge lengths of the overlap. Deterministic for any number of threads.
//   G. Turk, M. Levoy: Zippered polygon meshes from range images, SIGGRAPH 1994, chose the seam by
//   the border of one mesh and clipped the other against it.
SourcedMesh MergeSurfaces(const SourcedMesh& first, const SourcedMesh& second,
                          const SurfaceMergingOptions& options, const RunContext& context,
                          SurfaceMergingCounters* counters);

// The conflicts alone, as MergeSurfaces finds and decides them.
std::vector<ConflictPoint> FindConflicts(const SourcedMesh& first, const SourcedMesh& second,
                                         const SurfaceMergingOptions& options,
                                         const RunContext& context);

// The edge length in which the distances between two meshes are counted: that of the coarser.
double CoarserEdgeLength(const SourcedMesh& first, const SourcedMesh& second);

}  // namespace lsmvs
