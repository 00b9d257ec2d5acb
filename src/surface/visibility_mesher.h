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
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/util/checkpoint_folder.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// How much of the surface stays that no point supports.
enum class Completeness {
  kClosed,  // all that the cut closed inside of the surface; open only towards the scene's end, sky
  kSeen,    // gaps and webs inside go, too, where the evidence against them outweighs their border
  kStrict,  // every facet that spans what nobody measured goes
};

// Names and meanings are those of COLMAP's DelaunayMeshing.* where it has the same thing.
struct VisibilityMesherOptions {
  // Points closer than this in their views become one vertex that keeps all their views. Pixels; 0
  // merges exact duplicates only. Raising it makes a smaller, smoother mesh faster.
  double max_proj_dist = 2.2;
  // Points merge only if their depths differ by less than this fraction. Raising it merges more
  // along the viewing rays.
  double max_depth_dist = 0.01;
  // A point seen by n views counts 1 - exp(-n^2 / (2 visibility_sigma^2)): raising it trusts points
  // with few views less.
  double visibility_sigma = 3.0;
  // Uncertainty of a vertex along its rays, in units of the lengths of the edges around it. Raising
  // it smooths and closes over noise, but rounds detail and thin parts off.
  double distance_sigma_factor = 0.8;
  // How far behind a vertex, in units of its sigma, the inside is supported. Raising it thickens
  // thin parts.
  double sink_distance_factor = 0.5;
  // Weight of the shape of facets against one seen point. Raising it gives smoother surfaces and
  // less detail.
  double quality_regularization = 0.7;
  // What becomes of facets that span what nobody measured.
  Completeness completeness = Completeness::kClosed;
  // Gaps up to about this wide stay closed, and borders are smooth at that scale: as a share of the
  // photos' longer side, so that the same photos at another size give the same surface. It is twice
  // the price of a pixel of border in square pixels of facets that go beyond what is believed by a
  // factor e. Raising it keeps more and gives shorter borders. Not used by kStrict.
  double max_gap_share = 0.04;
  // Facets with an edge longer than this times the surface's edge length (the percentile below, in
  // pixels at that place) span what nobody measured. 0: no limit.
  double max_side_length_factor = 200.0;
  // Webs, which span what nobody measured between a foreground and what lies behind it, around what
  // was seen, or to false points, are dropped: facets that are long, reach far along the line of
  // sight of every view that sees one of their corners from the front, turn away from the normals
  // that the points at their corners had, and hang on a corner that few views saw. With L the
  // longest edge and D the least reach along lines of sight (both over the percentile below, in
  // pixels at that place), c the least cosine to the normals and t the trust in the corner that the
  // fewest views saw (0 to 1; see visibility_sigma; the less the more of the cloud's points the cut
  // found false): (L + 8 D) sqrt(1 - c) > max_web_factor t. Raising it closes more of what nobody
  // saw. 0 keeps all.
  double max_web_factor = 600.0;
  // Facets with an edge longer than this times the same percentile (less where few views saw a
  // corner, the more so the more of the cloud's points the cut found false) and more than
  // max_normal_angle_deg away from the normals at a corner are webs at any rate. Raising either
  // closes more of what nobody saw. 0 keeps all.
  double normal_check_factor = 32.0;
  double max_normal_angle_deg = 70.0;
  // Percentile of the surface's longest facet edges that counts as its edge length.
  double max_side_length_percentile = 50.0;
  // Components with less than this fraction of the largest one's faces, or with fewer faces than
  // min_component_faces, are dropped; the largest stays.
  double min_component_fraction = 0.002;
  int min_component_faces = 50;
  // Holes with at most this many edges are closed. 0 closes none.
  int max_hole_edges = 40;
  // Steps of volume-preserving smoothing after the cut. 0 returns the vertices where they were
  // measured.
  int smoothing_iterations = 0;
  // Coarser levels, each with about a 16th of the vertices of the one below, on which outliers are
  // looked for and dropped before the tetrahedra of the finest level are made (FilterFreeSpace).
  // Takes about a tenth more time for each level. Not used with max_proj_dist 0.
  int filter_levels = 0;
  // Also tell which points of the cloud the surface leaves in free space. 4 bytes per point.
  bool find_free_points = false;

  // "VisibilityMeshing.<field>".
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
  size_t num_rays = 0;               // (vertex, view) pairs
  size_t num_crossings = 0;          // facets crossed; where rays go one way together, once
  size_t num_lost_rays = 0;          // that reached neither camera nor hull: 0
  size_t num_empty_cells = 0;        // on the cameras' side of the cut
  size_t num_cut_facets = 0;         // of the cut, before cleaning
  size_t num_dropped_webs = 0;       // facets that spanned what nobody measured
  size_t num_split_vertices = 0;     // copies made so that the surface is manifold
  size_t num_components = 0;         // of the result
  size_t num_dropped_components = 0, num_dropped_component_faces = 0;
  size_t num_closed_holes = 0;
  double cut_value = 0;  // in units of one fully trusted ray
  // Of merging, cut and extraction, those whose results were found; see CheckpointFolder.
  size_t num_steps_found = 0;
};

struct VisibilityMesherResult {
  TriangleMesh mesh;  // with colours and normals
  // Views that see vertex v of the mesh: view_idxs[view_begin[v] .. view_begin[v+1]), ascending.
  // Empty for vertices that closing a hole added.
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
// dropped for that); without self-intersection when smoothing_iterations and max_hole_edges are 0;
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
// With a ScratchMemory the same work is done in parts, with the same bytes: the points are sorted
// by their places first, so that the order of the cloud does not matter; vertices lie along a
// Hilbert curve; tetrahedra are made tile by tile and stored in that order; rays go out block by
// block; the cut solves runs of tetrahedra that fit into memory and then augments across their
// walls. So each part is in memory while it is worked on, and is moved to the file and back a few
// times.
//   H.-H. Vu: Large-scale and high-quality multi-view stereo, PhD thesis, 2011, chapter 6, which
//   divides the points by a kd-tree; runs of a Hilbert curve are such parts.
VisibilityMesherResult MeshVisibilityCloud(const Scene& scene, VisibilityCloud cloud,
                                           const VisibilityMesherOptions& options,
                                           const RunContext& context);

// The same for a cloud that is read when it is needed, with what finished steps gave kept in
// `checkpoints`: if that is on, and after a kill finds the results of an earlier call with the same
// arguments, these steps are not done again, and the cloud is perhaps not read. Kept are, in bytes
// a vertex of the tetrahedralisation, the merged points (about 75; for 30 % of the time of a run),
// the labels of the tetrahedra after the cut (1; for 40 %) and the surface before it is cleaned
// (50, when the tetrahedra have gone; with these, for 25 % more). The tetrahedra are not: 220 bytes
// a vertex, or 350 with their weights, would be half of the scratch file again. So a run that is
// killed while it makes or weighs tetrahedra begins with them.
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
