#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// PatchMatch stereo with slanted planes, coarse to fine, one view at a time.
//
// A full run is two passes over all views. Each pass is independent from view to view given the
// maps of the pass before, so that a stopped run resumes at the next view and views can be spread
// over machines:
//   photometric  EstimateDepthMap(..., maps = null): images only. With `geom_consistency` its maps
//                stop at half resolution (level 1 of the image store) and are not filtered: they
//                only serve the next pass.
//   geometric    EstimateDepthMap(..., maps = the photometric maps): starts from the view's own
//                photometric map, asks that neighbours' photometric maps agree, refines to full
//                resolution and filters. What fusion takes.
// Without `geom_consistency` there is the photometric pass alone: full resolution and filtered.
struct PatchMatchOptions {
  // Half size of the matching window in pixels, at every level; twice that where there is little
  // texture above noise_sigma. Larger blurs detail: a plane does not fit the surface over the
  // window, least of all across an edge of depth. 5 x 5 samples close together lie nearer to the
  // truth than as many over 11 x 11 pixels, even with three times the usual sensor noise; what a
  // small window cannot tell apart, the coarser levels have settled.
  int window_radius = 2;
  // Pixels between samples of a window. Raising it is faster and noisier.
  int window_step = 1;
  // Sweeps over the coarsest level; finer levels need few. Cost grows little with it.
  int num_iterations = 8;
  // Neighbours that the coarse levels match with, and those kept in each small tile at full
  // resolution.
  int max_num_neighbors = 8;
  int max_num_fine_neighbors = 4;
  // Bilateral weights of the window: spatial in pixels (unset: the radius), colour in units of the
  // full grey range.
  std::optional<double> sigma_spatial;
  double sigma_color = 0.2;
  // Standard deviation of the sensor noise, in grey levels of 0-255. Windows with less texture than
  // that keep close to what coarser levels found; those with less than twice as much are wider.
  double noise_sigma = 2.0;

  // Run the geometric pass.
  bool geom_consistency = true;
  // Weight of a pixel of forward-backward error against 1 - ZNCC, and the error (pixels) at which
  // it is cut.
  double geom_consistency_regularizer = 0.3;
  double geom_consistency_max_cost = 3.0;

  bool filter = true;
  // Smallest ZNCC, mean over the views that match best.
  double filter_min_ncc = 0.1;
  // Smallest angle (degrees) between the rays of the reference and the best consistent neighbour.
  double filter_min_triangulation_angle = 3.0;
  // Neighbours that must agree with a pixel's depth. One keeps what only two views see, at the
  // borders of a scene; fusion decides what it trusts of that.
  int filter_min_num_consistent = 1;
  // Forward-backward error (pixels) up to which a neighbour agrees: a pixel of the half-resolution
  // maps that are compared with.
  double filter_geom_consistency_max_cost = 2.0;

  // Depth range in world units for every view; unset: from the sparse points (EstimateDepthRanges).
  std::optional<double> depth_min, depth_max;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Depth and normals of one view at the centres of its pixels.
//   neighbors  of this view, best first (SelectNeighbors); without any the map is empty of depths.
//   range      of the sparse points' depth in this view; widened inside. {0, 0}: empty map.
//   maps       null for the photometric pass; else the photometric maps of this view and its
//              neighbours (any resolution).
// Pixels that the mask excludes, that no neighbour sees or (where filtered) that fail a filter have
// depth 0. Same bytes for any number of threads. Memory: about 60 bytes per pixel of this view and
// 12 a pixel of each neighbour, plus what the image store and `maps` hold. Time: see
// EstimatePatchMatchCost. Papers: Bleyer et al., PatchMatch Stereo, BMVC 2011; Galliani et al.,
// Gipuma, ICCV 2015 (red-black propagation, best K views); Schoenberger et al., ECCV 2016
// (bilateral ZNCC, forward-backward geometric term); Xu and Tao, ACMM, CVPR 2019 (coarse to fine).
// We deviate in the plane's parameters (inverse depth and its slopes: a neighbour's plane is
// carried over by two multiply-adds), in sub-pixel refinement by parabola instead of random trials,
// and in doing full resolution once.
DepthMap EstimateDepthMap(const Scene& scene, const ImageStore& images, int view_idx,
                          const std::vector<Neighbor>& neighbors, const DepthRange& range,
                          const DepthMapSource* maps, const PatchMatchOptions& options,
                          const RunContext& context);

// Level of the image store that a photometric map with these options has.
int PhotometricLevel(const PatchMatchOptions& options);

// Both passes over all views of the scene. Memory: of the largest view, with the photos and maps
// that are held meanwhile.
CostEstimate EstimatePatchMatchCost(const Scene& scene, const ImageStore& images,
                                    const PatchMatchOptions& options);

}  // namespace lsmvs
