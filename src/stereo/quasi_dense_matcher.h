#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct QuasiDenseOptions {
  // Distance between interest points, pixels of each scale: one point a cell of this size where
  // there is texture. Time and number of points fall with its square.
  double spacing_px = 2.5;
  // Half size of the matching window in pixels, at every scale: 3 takes 7 x 7 pixels less the
  // corners. Larger is surer and blurs detail.
  int window_radius = 3;
  // The finest scale: level of the image store (0 full size, 1 half, ...). Time falls fourfold a
  // level.
  int finest_level = 0;
  // Scales, each half as large as the one before. Unset: until the longer side is below 256 pixels.
  std::optional<int> num_scales;
  // Standard deviation of the sensor noise, grey levels of 0-255. Windows whose texture is not
  // above it have no points.
  double noise_sigma = 2.0;

  // Neighbours matched on the coarse scales and those on the finest scale.
  int max_num_neighbors = 8;
  int max_num_fine_neighbors = 4;
  // Smallest ZNCC of a match. Lenient on purpose: the surface stage removes what is false.
  double min_ncc = 0.6;
  // Largest distance between a point and where its match is matched back to, pixels of the scale.
  double max_mutual_error_px = 1.0;
  // Views, the reference included, that must have matched each other for a point to be kept.
  int min_num_views = 2;
  // Largest reprojection error of an observation after optimisation, pixels; others leave the
  // track.
  double max_reproj_error_px = 1.0;
  // Error at which the robust (Cauchy) loss begins to flatten, pixels.
  double loss_scale_px = 0.5;
  // Smallest angle in degrees under which two views of a track see the point.
  double min_triangulation_angle_deg = 2.0;

  // Depth range in world units for every view; unset: from the sparse points (EstimateDepthRanges).
  std::optional<double> depth_min, depth_max;
  // Points outside are dropped. In the world of the files (Scene::world_offset is handled). Empty:
  // no limit.
  Eigen::AlignedBox3d bounding_box;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

enum class QuasiDenseStatus {
  kSuccess,
  kNoNeighbors,   // no view has a neighbour to be matched with; the cloud is empty
  kNoDepthRange,  // no sparse point before any camera, and no depth_min and depth_max
  kNoMatches,     // textureless photos, or nothing that matches; the cloud is empty
};

struct QuasiDenseCounters {
  size_t num_interest_points = 0;  // on the finest scale, all views
  size_t num_joined_keypoints = 0;
  size_t num_matched = 0;             // interest points with a match
  size_t num_mutual = 0;              // of those, confirmed by another view
  size_t num_tracks = 0;              // after joining what several views see
  size_t num_dropped_angle = 0;       // under too small an angle
  size_t num_dropped_error = 0;       // too few observations within max_reproj_error_px
  size_t num_dropped_cheirality = 0;  // behind a camera
  size_t num_dropped_outside = 0;     // of the bounding box
  size_t num_patches = 0;             // windows compared: what time is spent on
};

struct QuasiDenseResult {
  size_t num_points = 0, num_observations = 0;  // that went to the sink
  QuasiDenseStatus status = QuasiDenseStatus::kSuccess;
  std::string message;  // one line: what was made, or why nothing
  QuasiDenseCounters counters;
  PhaseSeconds seconds;
};

// Photos -> quasi-dense points with the views that see each of them.
//
// Interest points are matched from coarse to fine with positions on their epipolar lines in the
// neighbouring views; matches that are mutual become tracks, each triangulated and optimised as a
// whole.
//   neighbors  one list per view, best first (SelectNeighbors); made symmetric inside
//   keypoints  empty, or for each view the image coordinates (of the full-size photo) of points to
//              join
// Masked pixels have no points. The result does not depend on the number of threads. Throws
// UsageError for options out of range, CancelledError; nothing to match is a status.
// The points go to `sink` in parts, a view's at a time: positions, normals (towards the cameras),
// colours, views, whose number is a point's confidence.
// Memory: images within a fifth of the memory budget; interest points within another, but for those
// of a view and its neighbours (28 bytes each, one for each spacing_px^2 pixels at most), the rest
// in a temporary file; the points of one view. Besides them, a bit an interest point of the views
// whose turn is to come. Time: see EstimateQuasiDenseCost.
//   H.-H. Vu: Large-scale and high-quality multi-view stereo, thesis, 2011, chapter 4.2.1. M.
//   Lhuillier, L. Quan: A quasi-dense approach to surface reconstruction from uncalibrated images,
//   PAMI 27(3), 2005 (matches guide matches nearby).
// We deviate in comparing a point with positions between the interest points of the other view:
// dense points need not repeat from view to view.
QuasiDenseResult MatchQuasiDense(const Scene& scene, const ImageStore& images,
                                 const std::vector<std::vector<Neighbor>>& neighbors,
                                 std::span<const std::vector<Eigen::Vector2f>> keypoints,
                                 const QuasiDenseOptions& options, const CloudSink& sink,
                                 const RunContext& context);

// From the number of pixels, views and neighbours.
CostEstimate EstimateQuasiDenseCost(const Scene& scene, const ImageStore& images,
                                    const QuasiDenseOptions& options);

}  // namespace lsmvs
