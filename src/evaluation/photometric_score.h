#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/depth_tolerance.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct PhotometricOptions {
  // Neighbours that are warped into each view: those that share most sparse points with it.
  int num_neighbors = 4;
  // Level of the image pyramid: 0 full size, 1 half size. Each level costs a quarter of the time of
  // the one below.
  int level = 1;
  // Side of the window of the correlation, in pixels (odd).
  int window = 9;
  // Relative difference of depth above which a neighbour does not see the surface point.
  double depth_tolerance = kDefaultDepthTolerance;
  // Share of the window that must be seen.
  double min_window_share = 0.6;
  // Variance in squared grey levels below which a window has no texture and is not judged.
  double min_variance = 9;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

struct PhotometricViewScore {
  std::string name;
  size_t num_textured = 0;  // pixels whose window has texture
  size_t num_covered = 0;   // of these, seen through the mesh by a neighbour
  double sum_zncc = 0, sum_positive_zncc = 0;

  double Coverage() const;
  double MeanZncc() const;
  double Score() const;
};

struct PhotometricScore {
  std::vector<PhotometricViewScore> views;
  double coverage = 0;   // share of the textured pixels that a neighbour sees through the mesh
  double mean_zncc = 0;  // over the covered pixels, of the best neighbour
  double median_zncc = 0;
  double score = 0;  // mean over all textured pixels of max(zncc, 0); what is not covered counts 0
  // Per vertex the mean of the best ZNCC over the views that see it, NaN where none does; empty
  // unless asked for.
  std::vector<float> vertex_zncc;
};

// Scores a mesh by the photos, without truth: every neighbour's photo is warped through the mesh
// into the view and correlated (ZNCC over a window of seen pixels) with the view's own; per pixel
// the best neighbour counts. A surface at the wrong depth brings the wrong texture. Coverage and
// mean ZNCC must be read together: a mesh with only its easy parts has a high mean. Views that the
// reconstruction never saw give the honest score. `view_idxs`: the views that are scored (all if
// empty); neighbours come from all views. `tracer` is that of `mesh`. Masked pixels are not scored.
// Deterministic. O(#views * #neighbours * pixels); memory: depth of all views and a few images.
PhotometricScore MeasurePhotometricScore(const MeshTracer& tracer, const TriangleMesh& mesh,
                                         const Scene& scene, const ImageStore& images,
                                         const std::vector<int>& view_idxs, bool with_vertices,
                                         const PhotometricOptions& options,
                                         const RunContext& context);

}  // namespace lsmvs
