#include "lsmvs/evaluation/surface_evaluator.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "lsmvs/evaluation/photos/view_coverage.h"
#include "lsmvs/evaluation/samples/closest_points.h"
#include "lsmvs/evaluation/samples/surface_samples.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/statistics.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

using Points = std::vector<Eigen::Vector3d>;

// Edge, in GSD, of the voxels of which each counts once in the accuracy of a cloud.
constexpr double kVoxelSize = 2;

// Positive, finite and ascending; false otherwise.
bool ParseThresholds(const std::string& text, std::vector<double>* thresholds) {
  thresholds->clear();
  const char *next = text.data(), *end = next + text.size();
  while (true) {
    double value = 0;
    const auto [last, error] = std::from_chars(next, end, value);
    const double previous = thresholds->empty() ? 0 : thresholds->back();
    if (error != std::errc() || !std::isfinite(value) || !(value > previous)) return false;
    thresholds->push_back(value);
    if (last == end) return true;
    if (*last != ',') return false;
    next = last + 1;
  }
}

double Diagonal(const Points& vertices) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : vertices) {
    if (x.allFinite()) box.extend(x);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

// Value below which `share` of the values lie.
double ValueAbove(std::vector<double>* values, double share) {
  const size_t rank = std::min(values->size() - 1,
                               static_cast<size_t>(share * static_cast<double>(values->size())));
  return ValueOfRank(values, rank);
}

DistanceStatistics Summarize(std::vector<double> distances, const std::vector<double>& thresholds,
                             double unit, double max_mean_distance) {
  DistanceStatistics result;
  result.num_points = distances.size();
  result.shares.assign(thresholds.size(), 0.0);
  if (distances.empty()) return result;
  const double count = static_cast<double>(distances.size());
  double sum = 0;
  for (const double d : distances) sum += std::min(d, max_mean_distance * unit);
  result.mean = sum / count;
  for (size_t k = 0; k < thresholds.size(); ++k) {
    const auto right = std::count_if(distances.begin(), distances.end(),
                                     [&](double d) { return d < thresholds[k] * unit; });
    result.shares[k] = static_cast<double>(right) / count;
  }
  result.median = ValueAbove(&distances, 0.5);
  result.percentile_95 = ValueAbove(&distances, 0.95);
  return result;
}

template <class Distance>
std::vector<double> Distances(const Points& points, const RunContext& context,
                              const Distance& distance) {
  std::vector<double> result(points.size());
  ParallelFor(context, points.size(), 1024, [&](size_t i) { result[i] = distance(points[i]); });
  return result;
}

Points KeepSeen(const Points& points, const std::vector<int>& counts, int min_num_views) {
  Points kept;
  for (size_t i = 0; i < points.size(); ++i) {
    if (counts[i] >= min_num_views) kept.push_back(points[i]);
  }
  return kept;
}

size_t CountNotFinite(const Points& points) {
  return static_cast<size_t>(std::count_if(
      points.begin(), points.end(), [](const Eigen::Vector3d& x) { return !x.allFinite(); }));
}

double HarmonicMean(double a, double b) { return a + b > 0 ? 2 * a * b / (a + b) : 0; }

}  // namespace

void SurfaceEvaluationOptions::Describe(OptionSet* options) {
  options->Add("thresholds", &thresholds,
               "Distances within which a point is right, ascending, separated by commas, in "
               "units of --unit");
  options->AddEnum<DistanceUnit>("unit", &unit,
                                 "Unit of the thresholds: gsd (what one pixel covers on the "
                                 "surface; needs cameras) or world (the "
                                 "unit of the files)",
                                 {{"gsd", DistanceUnit::kGsd}, {"world", DistanceUnit::kWorld}});
  options->Add("num_samples", &num_samples,
               "Points drawn on each surface; raising it makes the figures more exact",
               {1, 100'000'000});
  options->Add("min_num_views", &min_num_views,
               "Leave out surface that fewer cameras see; 0 keeps all", {0, 1000});
  options->Add("visibility_tolerance_gsd", &visibility_tolerance_gsd,
               "A surface so close in front of a point does not hide it, in GSD", {0.0, 1e6});
  options->Add("max_mean_distance", &max_mean_distance,
               "Distances are cut here before averaging, in units of --unit", {1e-9, 1e12});
  options->Add("max_distance", &max_distance,
               "Larger distances count as this one, in units of --unit", {1e-9, 1e12});
}

bool SurfaceEvaluationOptions::Check(std::string* error) const {
  std::vector<double> parsed;
  if (!ParseThresholds(thresholds, &parsed)) {
    *error = fmt::format("thresholds = '{}' must be ascending positive numbers with commas between",
                         thresholds);
    return false;
  }
  if (parsed.back() > max_distance) {
    *error = fmt::format("thresholds = '{}' must not exceed max_distance = {}", thresholds,
                         max_distance);
    return false;
  }
  return CheckOptions(*this, error);
}

struct SurfaceEvaluator::State {
  State(const TriangleMesh& truth, const std::vector<View>& all_views,
        const SurfaceEvaluationOptions& given, const RunContext& context)
      : options(given), views(all_views), seed(context.seed) {
    RequireValid(options);
    ParseThresholds(options.thresholds, &thresholds);
    if (truth.faces.empty()) {
      true_cloud = std::make_unique<ClosestPoints>(truth.vertices);
    } else {
      true_tracer = std::make_unique<MeshTracer>(truth, context);
    }
    const Points drawn = Draw(truth, context);
    num_drawn = drawn.size();
    gsd = SurfaceSamplingDistance(drawn, views);
    SetUnit(Diagonal(truth.vertices));
    true_points = Seen(drawn, true_tracer.get(), context);
  }

  void SetUnit(double true_diagonal) {
    gsd_or_guess = gsd > 0 ? gsd : true_diagonal / 1000;
    unit = options.unit == DistanceUnit::kWorld ? 1 : gsd_or_guess;
  }

  Points Draw(const TriangleMesh& mesh, const RunContext& context) const {
    return SampleSurface(mesh, static_cast<size_t>(options.num_samples), seed, context);
  }
  Points DrawReconstruction(const TriangleMesh& mesh, const RunContext& context) const {
    if (!mesh.faces.empty()) return Draw(mesh, context);
    TriangleMesh thinned;
    thinned.vertices = OnePointPerVoxel(mesh.vertices, kVoxelSize * gsd_or_guess, seed);
    return Draw(thinned, context);
  }
  Points Seen(const Points& points, const MeshTracer* occluder, const RunContext& context) const {
    if (views.empty() || options.min_num_views == 0) return points;
    const double tolerance = options.visibility_tolerance_gsd * gsd;
    return KeepSeen(points, CountViews(points, views, occluder, tolerance, context),
                    options.min_num_views);
  }
  double ToTruth(const Eigen::Vector3d& x) const {
    const double max_distance = options.max_distance * unit;
    if (true_cloud) return true_cloud->Distance(x, max_distance);
    const auto closest = true_tracer->Closest(x, max_distance);
    return closest ? closest->distance : max_distance;
  }
  DistanceStatistics Measure(std::vector<double> distances, size_t drawn) const {
    DistanceStatistics result =
        Summarize(std::move(distances), thresholds, unit, options.max_mean_distance);
    result.num_unseen = drawn - result.num_points;
    return result;
  }

  SurfaceEvaluationOptions options;
  std::vector<View> views;
  uint64_t seed;
  std::vector<double> thresholds;
  std::unique_ptr<MeshTracer> true_tracer;
  std::unique_ptr<ClosestPoints> true_cloud;
  Points true_points;  // seen
  size_t num_drawn = 0;
  double gsd = 0, gsd_or_guess = 0, unit = 1;
};

SurfaceEvaluator::SurfaceEvaluator(const TriangleMesh& truth, const std::vector<View>& views,
                                   const SurfaceEvaluationOptions& options,
                                   const RunContext& context)
    : state_(std::make_unique<State>(truth, views, options, context)) {}

SurfaceEvaluator::~SurfaceEvaluator() = default;

double SurfaceEvaluator::gsd() const { return state_->gsd; }
double SurfaceEvaluator::unit_in_world() const { return state_->unit; }
const MeshTracer* SurfaceEvaluator::truth_tracer() const { return state_->true_tracer.get(); }

double SurfaceEvaluator::DistanceToTruth(const Eigen::Vector3d& x_in_world) const {
  return state_->ToTruth(x_in_world);
}

namespace {

void SetStatus(bool no_samples, bool no_truth, bool nothing_seen, SurfaceEvaluation* result) {
  if (no_truth) {
    result->status = SurfaceEvaluation::Status::kEmptyTruth;
    result->message = "the ground truth has no surface that enough cameras see";
  } else if (no_samples) {
    result->status = SurfaceEvaluation::Status::kEmptyReconstruction;
    result->message = "the reconstruction has no points and no area";
  } else if (nothing_seen) {
    result->status = SurfaceEvaluation::Status::kNothingSeen;
    result->message = "no part of the reconstruction is seen by enough cameras";
  }
}

}  // namespace

SurfaceEvaluation SurfaceEvaluator::Evaluate(const TriangleMesh& reconstruction,
                                             const RunContext& context,
                                             const MeshTracer* tracer) const {
  const State& s = *state_;
  SurfaceEvaluation result;
  result.is_cloud = reconstruction.faces.empty();
  result.num_vertices = reconstruction.vertices.size();
  result.num_faces = reconstruction.faces.size();
  result.gsd = s.gsd;
  result.unit_in_world = s.unit;
  result.thresholds = s.thresholds;

  Stopwatch watch;
  std::unique_ptr<MeshTracer> own_tracer;
  if (!result.is_cloud && tracer == nullptr) {
    own_tracer = std::make_unique<MeshTracer>(reconstruction, context);
    tracer = own_tracer.get();
  }
  const Points drawn = s.DrawReconstruction(reconstruction, context);
  result.sampling_seconds = watch.Lap();
  const Points points = result.is_cloud ? drawn : s.Seen(drawn, tracer, context);
  result.visibility_seconds = watch.Lap();
  context.Report(0.5);

  const double max_distance = s.options.max_distance * s.unit;
  result.accuracy =
      s.Measure(Distances(points, context, [&](const Eigen::Vector3d& x) { return s.ToTruth(x); }),
                drawn.size());
  if (result.is_cloud) {
    const ClosestPoints cloud(reconstruction.vertices);
    result.num_not_finite = CountNotFinite(reconstruction.vertices);
    result.completeness = s.Measure(
        Distances(s.true_points, context,
                  [&](const Eigen::Vector3d& x) { return cloud.Distance(x, max_distance); }),
        s.num_drawn);
  } else {
    result.num_not_finite = tracer->num_left_out();
    result.completeness = s.Measure(Distances(s.true_points, context,
                                              [&](const Eigen::Vector3d& x) {
                                                const auto c = tracer->Closest(x, max_distance);
                                                return c ? c->distance : max_distance;
                                              }),
                                    s.num_drawn);
  }
  for (size_t k = 0; k < s.thresholds.size(); ++k) {
    result.f1.push_back(HarmonicMean(result.accuracy.shares[k], result.completeness.shares[k]));
  }
  SetStatus(drawn.empty(), s.true_points.empty(), points.empty(), &result);
  result.distance_seconds = watch.Lap();
  context.Report(1);
  return result;
}

SurfaceEvaluation EvaluateSurface(const TriangleMesh& reconstruction, const TriangleMesh& truth,
                                  const std::vector<View>& views,
                                  const SurfaceEvaluationOptions& options,
                                  const RunContext& context) {
  return SurfaceEvaluator(truth, views, options, context).Evaluate(reconstruction, context);
}

CostEstimate EstimateSurfaceEvaluation(size_t num_faces, size_t num_true_faces, size_t num_views,
                                       const SurfaceEvaluationOptions& options) {
  const double faces = static_cast<double>(num_faces + num_true_faces);
  const double samples = 2.0 * options.num_samples;
  CostEstimate estimate;
  // Building the trees, closest points, and a ray to each view.
  estimate.cpu_seconds =
      1.2e-6 * faces + samples * (6e-6 + 0.7e-6 * static_cast<double>(num_views));
  estimate.peak_bytes = static_cast<size_t>(200 * faces + 60 * samples);
  return estimate;
}

}  // namespace lsmvs
