#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/cloud_sample.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/surface/cleaning_options.h"
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/visibility_weights.h"
#include "lsmvs/util/checkpoint_folder.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Names and meanings are those of COLMAP's DelaunayMeshing.* where it has the same thing.
struct VisibilityMesherOptions {
  PointMergingOptions merging;
  VisibilityWeightOptions weights;
  SurfaceCleaningOptions cleaning;
  // Coarser levels, each with about a 16th of the vertices of the one below, on which outliers are
  // looked for and dropped before the tetrahedra of the finest level are made (FilterFreeSpace).
  // Takes about a tenth more time for each level. Not used with max_proj_dist 0.
  int filter_levels = 0;
  // Also tell which points of the cloud the surface leaves in free space. 4 bytes per point.
  bool find_free_points = false;

  // "VisibilityMeshing.<field>", whatever group of fields it is in.
  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

enum class VisibilityMesherStatus {
  kSuccess,
  kNoPoints,    // no finite point that a view sees; the mesh is empty
  kDegenerate,  // fewer than four vertices after merging, or all in one plane; the mesh is empty
  kEmptyCut,    // the visibility supports no surface; the mesh is empty
};

struct VisibilityMesherCounters {
  size_t num_points = 0;             // in the cloud
  size_t num_ignored_points = 0;     // not finite, without views, or behind all of their views
  size_t num_filtered_vertices = 0;  // dropped on coarser levels
  size_t num_vertices = 0;           // of the tetrahedralisation, after merging and filtering
  size_t num_cells = 0;              // tetrahedra, those at infinity included
  RayCounters rays;
  size_t num_empty_cells = 0;     // on the cameras' side of the cut
  size_t num_cut_facets = 0;      // of the cut, before cleaning
  size_t num_split_vertices = 0;  // copies made so that the surface is manifold
  SurfaceCleaningCounters cleaning;
  double cut_value = 0;  // in units of one fully trusted ray
  // Of merging, cut and extraction, those whose results were found; see CheckpointFolder.
  size_t num_steps_found = 0;
};

struct VisibilityMesherResult {
  TriangleMesh mesh;  // with colours and normals
  // Views that see vertex v of the mesh: view_idxs[view_begin[v] .. view_begin[v+1]), ascending.
  // Empty for vertices that are no points: middles of split edges, and spikes that sank.
  std::vector<uint64_t> view_begin = {0};
  std::vector<uint32_t> view_idxs;
  // With find_free_points, by point of the cloud: 1 if all tetrahedra around its vertex are empty,
  // or it was ignored: an outlier that the views contradict.
  std::vector<uint8_t> point_is_free;
  VisibilityMesherStatus status = VisibilityMesherStatus::kSuccess;
  std::string message;  // one line: what was made, or why nothing
  VisibilityMesherCounters counters;
  PhaseSeconds seconds;
  size_t predicted_peak_bytes = 0;  // MeshingSize::PeakBytes of the merged points
  size_t measured_peak_bytes = 0;   // growth of this process while meshing
};

// The surface that is consistent with what each view saw: Delaunay tetrahedralisation of the merged
// points, tetrahedra labelled empty or full by a minimum s-t cut, surface = facets between empty
// and full.
//   P. Labatut, J.-P. Pons, R. Keriven: Robust and efficient surface reconstruction from range
//   data, CGF 28(8), 2009. H.-H. Vu, P. Labatut, J.-P. Pons, R. Keriven: High accuracy and
//   visibility-consistent dense multiview stereo, PAMI 34(5), 2012.
// Deviations: points that merge give their views, and their weight, to the vertex, which lies at
// their mean; the uncertainty sigma is each vertex' own, from the edges around it; weights are
// fixed-point integers, so that the cut is exact.
//
// The mesh: faces counter-clockwise seen from the cameras; manifold (vertices are split, no face is
// dropped for that); without self-intersection when smoothing_iterations and max_hole_edges are 0
// (lone spikes sink only where nothing crosses; without min_spike_factor all vertices are points);
// closed except at the hull of the points and where facets were trimmed (Completeness). Same bytes
// for any number of threads; independent of the scene's unit, position and orientation up to the
// rounding of the float input.
//
// The cloud is freed as soon as its points are merged.
//
// Throws UsageError for options out of range; MemoryError if what merging, or then the merged
// points, need exceeds context.memory_budget_bytes and no ScratchMemory is on; CancelledError.
// Nothing to mesh is a status, not an error. Memory: see MeshingSize, about 0.6 kB per vertex of
// the tetrahedralisation; time about O(n log n), see EstimateVisibilityMesherCost.
//
// With a ScratchMemory the same work is done in parts, with the same bytes: points are sorted by
// their places first, so that the order of the cloud does not matter.
VisibilityMesherResult MeshVisibilityCloud(const Scene& scene, VisibilityCloud cloud,
                                           const VisibilityMesherOptions& options,
                                           const RunContext& context);

// The same for a cloud that is read when it is needed, with what finished steps gave kept in
// `checkpoints`: if that is on, and after a kill finds the results of an earlier call with the same
// arguments, these steps are not done again, and the cloud is perhaps not read.
VisibilityMesherResult MeshVisibilityCloud(const Scene& scene,
                                           const std::function<VisibilityCloud()>& read_cloud,
                                           const VisibilityMesherOptions& options,
                                           const RunContext& context,
                                           const CheckpointFolder& checkpoints);

// How the points of a cloud lie on the surface.
enum class PointSpacing {
  kRegular,  // about a pixel apart, as depth maps give them
  kRandom,   // any cloud: many more fall together
};

// Of the tetrahedralisation of `num_points`: one for each square of max_proj_dist pixels of the
// surface, whose area in full-size pixels follows from the sparse points (EstimateSurfaceShare),
// where there are points enough.
size_t EstimateVisibilityMesherVertices(const Scene& scene, size_t num_points, PointSpacing spacing,
                                        const VisibilityMesherOptions& options);

// For a cloud with `num_view_entries` (point, view) pairs.
MeshingSize EstimateMeshingSize(const Scene& scene, size_t num_points, size_t num_view_entries,
                                PointSpacing spacing, const VisibilityMesherOptions& options,
                                int num_threads);

// The same for a cloud that is there, from a sample of it: the points of each place are merged, and
// those within its cube are counted. About 0.1 s.
MeshingSize MeasureMeshingSize(const Scene& scene, const CloudSample& sample,
                               const VisibilityMesherOptions& options, int num_threads);

// Memory includes the cloud.
CostEstimate EstimateVisibilityMesherCost(const MeshingSize& size);

}  // namespace lsmvs
