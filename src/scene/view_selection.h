#pragma once

#include <string>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct ViewSelectionOptions {
  // Neighbours kept a view, best first. More neighbours cost time in stereo and help where surfaces
  // are occluded.
  int max_num_neighbors = 8;
  // Pairs that see a point under less than this angle (degrees, median over the shared points) give
  // no depth.
  double min_triangulation_angle_deg = 1.0;
  // Pairs above this median angle look too different to match.
  double max_triangulation_angle_deg = 60.0;
  // The angle that matches best: score falls off on both sides.
  double best_triangulation_angle_deg = 12.0;
  // Shared sparse points below which a pair is not trusted.
  int min_num_shared_points = 5;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

struct Neighbor {
  int view_idx = -1;
  double score = 0;             // larger is better
  double median_angle_deg = 0;  // triangulation angle over the shared points
  int num_shared_points = 0;
  // Chosen because both views look at the same place: they share too few points to tell.
  bool by_overlap = false;
};

// For each view its neighbours for stereo, best first; empty where nothing overlaps. The score of a
// pair is the sum over its shared sparse points of angle_weight * scale_weight, with angle_weight =
// min(angle/best, best/angle)^1.5 and scale_weight = min(gsd ratio, 1/gsd ratio), times how evenly
// the shared points cover the view.
//
// Where texture is soft, photos of the same place may share hardly any points. Views that have
// fewer than four neighbours that way get others up to four, after those, by overlap: in the place
// of shared points come the sparse points that lie in both images, within the depth ranges of both
// views, and that some view sees from within 60 degrees of this one, at 50 degrees at most; or,
// where there are hardly any, a grid of pixels at the middle of the view's depth range. Without any
// shared points (a model without tracks) the nearest views from other places (CenterGroups) whose
// axes agree within 45 degrees are taken, those with like axes first.
//
// Photos that show the same from nearly one place (SameSights with the minimum triangulation angle:
// a photo that is twice in the model, bursts) count as one: the better one is a neighbour. The
// other one is left out, or comes last if it stands a little apart and the view has fewer than four
// neighbours otherwise.
//
// Views without a photo are nobody's neighbours. Deterministic; ties are broken by view_idx. Time:
// O(sum over points of views^2); where the points of a view are seen by more than 500,000 views in
// all, every n-th point is looked at, and counts n-fold. Memory beyond the scene: 4 bytes an
// observation, and for each thread 4 bytes for every pair of an observation of its view and another
// of the same point.
std::vector<std::vector<Neighbor>> SelectNeighbors(const Scene& scene,
                                                   const ViewSelectionOptions& options,
                                                   const RunContext& context);

}  // namespace lsmvs
