#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/depth_tolerance.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/checkpoint_folder.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

enum class LaplacianWeights {
  kUniform,    // every neighbour counts the same: robust on irregular triangles
  kCotangent,  // neighbours count by the cotangents of the opposite angles, clamped to positive
};

enum class RefinementOptimizer {
  kGaussNewton,  // damped Gauss-Newton steps, judged region by region
  kLbfgs,        // L-BFGS with a line search over the whole surface, for comparison: slower
};

enum class RefinementDeformation {
  kIndependent,  // all parts of the surface move in the same step, coupled as one surface
  kSequential,   // parts move one colour after the other, while their neighbours are held
};

struct MeshRefinerOptions {
  // Pyramid levels, coarse to fine: 3 starts at a quarter of the resolution. More levels pull in
  // vertices that are further from the surface. Levels whose images would be smaller than 64 pixels
  // are left out.
  int num_levels = 3;
  RefinementOptimizer optimizer = RefinementOptimizer::kGaussNewton;
  // Which parts of the surface move in a step of Gauss and Newton.
  RefinementDeformation deformation = RefinementDeformation::kIndependent;
  // Steps per level at most; a level ends earlier when its regions have converged.
  int max_num_iterations = 5;
  // Half side of the correlation window in pixels: 3 is 7 x 7. Larger is more stable and smoother.
  int window_radius = 3;
  // Neighbours that a view may be compared with.
  int max_num_neighbors = 6;
  // Ordered pairs of views that judge one facet: the best by parallax, resolution and grazing
  // angle. Time grows with it.
  int max_pairs_per_face = 6;
  // Triangulation angles (degrees) at which a pair says something about a facet.
  double min_triangulation_angle_deg = 2.0;
  double max_triangulation_angle_deg = 50.0;
  // Weight of the thin plate, the integral of the squared Laplacian with lengths in pixels, against
  // the sum of 1 - ZNCC over pixels. Raising it smooths; it depends neither on the unit of the
  // scene nor on the size of the facets.
  double smoothness = 0.05;
  // How many times stiffer the plate is where the surface is flat for its surroundings than where
  // it has creases (see CreaseWeights). Raising it takes more noise out of plain surfaces; 1: the
  // same everywhere, as it is with L-BFGS and in the first step of a level.
  double flat_stiffness = 30.0;
  // Passes of a filter that takes noise of the size of single triangles off the input, and off the
  // result, and leaves edges sharp (see FilterNoise). Raising them flattens small relief. 0: none.
  int input_filter_passes = 2, result_filter_passes = 1;
  // Weight of the membrane (length in pixels) relative to the thin plate. Raising it shrinks thin
  // parts.
  double membrane = 0.0;
  // Weight of the square of a vertex' way from its input (pixels, per square pixel of surface)
  // where the photos show no texture; the more texture, the less. It holds what the
  // photos do not determine, such as plain walls; raising it keeps more of the input's noise there.
  double anchor = 0.0005;
  LaplacianWeights laplacian = LaplacianWeights::kUniform;
  // Standard deviation in grey levels that is added to that of every window: windows flatter than
  // this count little.
  double noise_gray_levels = 2.0;
  // A point is hidden in the other view if the surface there is nearer by more than this part of
  // its depth.
  double depth_tolerance = kDefaultDepthTolerance;
  // Longest step of a vertex in one iteration, in pixels of the level.
  double max_step_px = 1.0;
  // A level ends when a step lowers the energy by less than this part of it.
  double min_relative_gain = 0.002;
  // Facets are split while the best pair of views sees more than this many square pixels (the
  // smaller of the pair's two areas). 0: the facets stay as they are.
  double max_face_area_px = 16.0;
  // Flip and collapse edges so that the triangles stay regular.
  bool improve_mesh = true;
  // Regions that lost more photo-consistency than they gained in smoothness return to their input.
  bool guard = true;
  // At the ends of the surface, faces go through which textured photos disagree, where that is
  // worth the border: a pixel of border costs as much as a strip of such faces that is half as wide
  // as this share of the photos' longer side. Raising it gives smoother borders and keeps more
  // inside of them. 0: none go.
  double max_gap_share = 0.04;
  // Holes of at most so many edges are closed at the end. 0: none.
  int max_hole_edges = 40;
  // Every n-th view takes no part in the refinement, only in the guard. 0: all take part.
  int hold_out_every = 0;
  // The result has as few faces as keep it within this distance (pixels of the view that sees the
  // place finest) of the refined surface. Raising it gives smaller files; vertex colours, one a
  // vertex, get coarser with it. 0: all faces stay.
  double simplify_tolerance = 0.25;
  bool color_vertices = true;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

enum class RefinementStatus {
  kRefined,
  kUnchanged,  // no pair of views sees the mesh: it has the faces of the input; `message` says why
};

// One pyramid level.
struct RefinementLevelSummary {
  int level = 0;                 // 0 = full resolution of the store
  int num_iterations = 0;        // accepted and rejected
  int num_rejected_regions = 0;  // summed over the iterations
  // Regions that had stopped moving, each by itself, when the level ended; of all.
  int num_stopped_regions = 0, num_regions = 0;
  // Vertices that returned to where they were before the level because the surface would have
  // passed through itself.
  size_t num_collisions_undone = 0;
  size_t num_faces = 0;  // after adaptation to the level
  // Mean of 1 - ZNCC over all pixels of all pairs, before the first and after the last step of the
  // level.
  double initial_photo_error = 0, final_photo_error = 0;
  // After every evaluation, what is minimised: photo error summed over pixels plus smoothness.
  // Where the plate is stiffened between steps, with the stiffness of the step that follows.
  std::vector<double> energies;
  double seconds = 0;
};

// What a refinement counted; plain numbers.
struct RefinementCounts {
  size_t num_faces_seen = 0;     // by at least one pair, of the input
  size_t num_faces_refined = 0;  // before simplification
  size_t num_splits = 0, num_flips = 0, num_collapses = 0;
  size_t num_regions = 0, num_regions_restored = 0;  // by the guard
  size_t num_dropped_faces = 0;                      // at the ends of the surface
  size_t num_closed_holes = 0;
  // Mean of 1 - ZNCC at full resolution of the filtered input and of the result.
  double input_photo_error = 0, output_photo_error = 0;
};

struct RefinementResult : RefinementCounts {
  // With vertex_colors if asked for, and with vertex_quality (VertexQuality) where max_gap_share is
  // not 0; orientation as in the input.
  TriangleMesh mesh;
  RefinementStatus status = RefinementStatus::kRefined;
  std::string message;  // one line

  int num_pairs = 0;                           // ordered pairs of views
  std::vector<RefinementLevelSummary> levels;  // coarse to fine
  size_t num_steps_found = 0;                  // that an earlier run had finished

  double prepare_seconds = 0, filter_seconds = 0, optimize_seconds = 0, remesh_seconds = 0,
         guard_seconds = 0, simplify_seconds = 0, color_seconds = 0;
};

// Moves the vertices of a mesh so that photos agree through it (photometric variational
// refinement), and adapts the triangles to what the photos resolve.
//
// Minimises sum over ordered pairs (i, j) of views, over the pixels of i, of 1 - ZNCC(I_i, I_j
// reprojected into i through the surface), plus a thin-plate term that is stiff where the surface
// is flat and soft at its creases. ZNCC is taken over a square
// window, over the pixels that both views see; it does not change under gain and offset of a photo.
// The derivative is the exact one of the sampled (bilinear) interpolant except across occlusion
// boundaries. Each step solves (H + S) d = -g for displacements d along the vertex normals, g the
// exact gradient, H the lumped Gauss-Newton matrix of the photo term, S that of the thin plate;
// steps are cut at `max_step_px`, accepted or rejected region by region, and damped where they were
// rejected.
//
// At the end faces go through which textured photos have nothing in common, at the surface's ends
// alone, and small holes are closed (see FinishSurface). Then edges are collapsed within
// `simplify_tolerance` (see SimplifyWithinTolerance); colours are taken from the photos after that,
// so that they are as sharp as these.
//
// Before the first and after the last level, noise of the size of single triangles is taken off by
// the normals of the faces, which are averaged on either side of edges (see FilterNoise): steps
// along vertex normals cannot unfold a crumpled input. "Input", here and in the options, is the
// mesh after that, which nothing judges.
//
// Input: any triangle mesh; non-manifold edges are kept and not split. Facets oriented towards the
// cameras. Output: manifold where the input is. If `guard`, the photo error of no region is more
// than a twentieth above that of the input, and above it only where the surface is smoother, but
// for what the simplification tolerates. Facets that no pair sees stay where they are.
// Deterministic for any number of threads; does not depend on the scale, rotation or translation of
// the scene beyond rounding. Memory: 8 bytes per pixel of the views in use at a time (bounded by
// the context's budget) plus about 400 bytes per vertex, and what the image store holds; `mesh` is
// taken over (move it in). Time: about 60 ns per pixel and pair for each iteration. Throws
// UsageError for options that fail Check(), CancelledError, and what the image store throws.
//
// J.-P. Pons, R. Keriven, O. Faugeras, "Multi-view stereo reconstruction and scene flow estimation
// with a global image-based matching score", IJCV 72(2), 2007; H.-H. Vu, P. Labatut, J.-P. Pons, R.
// Keriven, "High accuracy and visibility-consistent dense multiview stereo", PAMI 34(5), 2012. We
// deviate in the optimiser (they descend the gradient), in choosing pairs per facet, and in
// guarding the result.
//
// Where there are `checkpoints`, each level that is finished is kept there, then the judged mesh; a
// run that finds some goes on behind them, with the same result. (`levels` lists those of this
// run.)
RefinementResult RefineMesh(const Scene& scene, const ImageStore& images, TriangleMesh mesh,
                            const MeshRefinerOptions& options, const RunContext& context,
                            const CheckpointFolder& checkpoints = {});

// From the pixels of the views, the faces of the input and those that the target facet size implies
// (the surface's area in pixels follows from the tracks of the sparse points). `context` says the
// threads and the budget of memory.
CostEstimate EstimateRefinementCost(const Scene& scene, const ImageStore& images,
                                    size_t num_input_faces, const MeshRefinerOptions& options,
                                    const RunContext& context);

// Memory below which a refinement with a scratch file had better not start, although it needs
// `needed_bytes`: threads would wait for photos and maps all the time.
size_t LeastRefinementBytes(const ImageStore& images, size_t num_input_faces, size_t needed_bytes,
                            int num_threads);

// On disk, of the steps of a refinement that are kept for a run that is killed.
size_t RefinementCheckpointBytes(size_t num_input_faces, const MeshRefinerOptions& options);

}  // namespace lsmvs
