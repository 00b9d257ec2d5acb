#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

enum class DistanceUnit {
  kGsd,    // ground sampling distance: what one pixel covers on the true surface
           // (SurfaceSamplingDistance)
  kWorld,  // the unit of the files
};

struct SurfaceEvaluationOptions {
  // Distances within which a point counts as right, ascending, separated by commas, in `unit`.
  std::string thresholds = "0.5,1,2,4";
  // kGsd needs views. Without views, and with the default thresholds, 1 unit is a thousandth of the
  // diagonal of the truth.
  DistanceUnit unit = DistanceUnit::kGsd;
  // Points drawn on each surface before those that too few views see are dropped. The standard
  // error of a share is at most 0.5 / sqrt(num_samples): 0.001 for the default.
  int num_samples = 300000;
  // Points that fewer views see are left out, of both surfaces. 0: all count.
  int min_num_views = 2;
  // What may hide a point without making it unseen, in GSD: the surface itself at grazing angles.
  double visibility_tolerance_gsd = 1.5;
  // Distances are cut here before they are averaged, in `unit`: a far outlier is only wrong, not
  // infinitely wrong.
  double max_mean_distance = 10;
  // Distances are searched up to here, in `unit`; what is farther counts as being so far away.
  double max_distance = 50;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

// Distances from the points of one surface to the other.
struct DistanceStatistics {
  size_t num_points = 0;       // drawn and seen
  size_t num_unseen = 0;       // drawn, but left out
  std::vector<double> shares;  // of the points within each threshold, in [0, 1]
  double mean =
      0;  // of the distances cut at max_mean_distance; this and the next two in world units
  double median = 0;
  double percentile_95 = 0;
};

struct SurfaceEvaluation {
  enum class Status { kOk, kEmptyReconstruction, kEmptyTruth, kNothingSeen };
  Status status = Status::kOk;
  std::string message;  // says what is wrong if the status is not kOk
  bool is_cloud = false;
  double gsd = 0;                   // world units; 0 without views
  double unit_in_world = 1;         // of the thresholds
  std::vector<double> thresholds;   // in that unit
  DistanceStatistics accuracy;      // reconstruction to truth
  DistanceStatistics completeness;  // truth to reconstruction
  std::vector<double> f1;           // harmonic mean of the two shares, a threshold
  size_t num_vertices = 0, num_faces = 0;
  size_t num_not_finite = 0;  // faces (points of a cloud) of the reconstruction that were left out
  double sampling_seconds = 0, visibility_seconds = 0, distance_seconds = 0;
};

// Scores meshes or clouds against a true mesh (or a true cloud, such as a laser scan).
//   accuracy(d): share of the reconstructed surface that lies within d of the truth;
//   completeness(d): share of the true surface that lies within d of the reconstruction;
//   F1(d): their harmonic mean.
// Both are measured on points drawn uniformly over the area, so that neither depends on how fine a
// surface is meshed, and only where at least `min_num_views` views see the surface that the points
// are drawn on. Of a cloud one point per voxel of 2 GSD (without views, of the
// diagonal of the truth / 500) counts for accuracy, so that a part does
// not count more where points are dense (it hides nothing from a camera: seen or not does not
// matter), and completeness is the distance to its nearest point.
//
// Differences from Schoeps et al., "A multi-view stereo benchmark with high-resolution images and
// multi-camera videos" (ETH3D), CVPR 2017: there the reconstruction is a cloud and the truth a
// laser scan; both are averaged over cells of a grid instead of over area; a reconstructed point
// far from the scan is left out of the accuracy, instead of counting as wrong, if the scanner did
// not look there; there is no condition on the photos' view. Thresholds in world units with a true
// cloud and min_num_views = 0 come closest to it. Knapitsch et al., "Tanks and Temples", 2017, is
// the same as ours up to their voxel grid in place of area-uniform points.
class SurfaceEvaluator {
 public:
  // Draws the points of the truth. `views` may be empty: then all points count. Throws UsageError
  // if the options need views.
  SurfaceEvaluator(const TriangleMesh& truth, const std::vector<View>& views,
                   const SurfaceEvaluationOptions& options, const RunContext& context);
  ~SurfaceEvaluator();

  double gsd() const;
  double unit_in_world() const;
  // Null if the truth is a cloud.
  const MeshTracer* truth_tracer() const;
  // Distance to the truth, at most max_distance (world units).
  double DistanceToTruth(const Eigen::Vector3d& x_in_world) const;

  // A mesh without faces is a cloud. O((F + num_samples * #views) log F). `tracer`: of the
  // reconstruction, if there is one already.
  SurfaceEvaluation Evaluate(const TriangleMesh& reconstruction, const RunContext& context,
                             const MeshTracer* tracer = nullptr) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// SurfaceEvaluator for a single reconstruction.
SurfaceEvaluation EvaluateSurface(const TriangleMesh& reconstruction, const TriangleMesh& truth,
                                  const std::vector<View>& views,
                                  const SurfaceEvaluationOptions& options,
                                  const RunContext& context);

// From the sizes of the meshes, the number of samples and of views.
CostEstimate EstimateSurfaceEvaluation(size_t num_faces, size_t num_true_faces, size_t num_views,
                                       const SurfaceEvaluationOptions& options);

}  // namespace lsmvs
