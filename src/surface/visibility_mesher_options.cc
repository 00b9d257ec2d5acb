#include <algorithm>
#include <cmath>

#include "lsmvs/scene/surface_share.h"
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/visibility_mesher.h"

namespace lsmvs {

void VisibilityMesherOptions::Describe(OptionSet* options) {
  const std::string group = "VisibilityMeshing.";
  options->Add(
      group + "max_proj_dist", &merging.max_proj_dist,
      "Points closer than this (pixels) in their views become one vertex; raising it gives a "
      "smaller, smoother mesh",
      {0, 1000});
  options->Add(group + "max_depth_dist", &merging.max_depth_dist,
               "Points merge only if their depths differ by less than this fraction", {0, 1});
  options->Add(
      group + "visibility_sigma", &merging.visibility_sigma,
      "A point seen by n views counts 1 - exp(-n^2 / (2 sigma^2)); raising it trusts points "
      "with few views less",
      {0.01, 100});
  options->Add(group + "distance_sigma_factor", &weights.distance_sigma_factor,
               "Uncertainty of a vertex along its rays, in lengths of the edges around it; raising "
               "it smooths",
               {0.01, 100});
  options->Add(group + "sink_distance_factor", &weights.sink_distance_factor,
               "How far behind a vertex the inside is supported, in units of its uncertainty",
               {0, 10});
  options->Add(group + "quality_regularization", &weights.quality_regularization,
               "Weight of the shape of facets; raising it gives smoother surfaces and less detail",
               {0, 1e4});
  options->AddEnum(
      group + "completeness", &cleaning.completeness,
      "What becomes of facets that span what nobody measured: closed keeps them inside "
      "of the surface, seen drops them there, too, strict drops each by itself",
      {{"closed", Completeness::kClosed},
       {"seen", Completeness::kSeen},
       {"strict", Completeness::kStrict}});
  options->Add(group + "max_gap_share", &cleaning.max_gap_share,
               "Width of gaps that stay closed, as a share of the photos' longer side; raising it "
               "keeps more and gives smoother borders",
               {0, 1});
  options->Add(group + "max_side_length_factor", &cleaning.max_side_length_factor,
               "Facets with an edge longer than this times the usual edge length span what nobody "
               "measured; 0: no limit",
               {0, 1e6});
  options->Add(
      group + "max_web_factor", &cleaning.max_web_factor,
      "Facets that are long, deep along all lines of sight and against the points' normals "
      "span what nobody measured, sooner where few views saw a corner; raising it keeps more; 0: "
      "no limit",
      {0, 1e6});
  options->Add(group + "normal_check_factor", &cleaning.normal_check_factor,
               "Facets with an edge longer than this times the usual edge length (less where few "
               "views saw them and many points are false) must agree with the points' normals; "
               "raising it closes more of what nobody saw; 0 checks none",
               {0, 1e6});
  options->Add(group + "max_normal_angle_deg", &cleaning.max_normal_angle_deg,
               "Angle (degrees) to the normals of the points at its corners up to which such a "
               "facet agrees with them; raising it closes more of what nobody saw",
               {0, 180});
  options->Add(group + "max_side_length_percentile", &cleaning.max_side_length_percentile,
               "Percentile of the longest facet edges that is the usual edge length", {0, 100});
  options->Add(group + "min_component_fraction", &cleaning.min_component_fraction,
               "Components with less than this fraction of the largest one's faces are dropped",
               {0, 1});
  options->Add(group + "min_component_faces", &cleaning.min_component_faces,
               "Components with fewer faces are dropped", {0, std::numeric_limits<int>::max()});
  options->Add(group + "max_hole_edges", &cleaning.max_hole_edges,
               "Holes with at most this many edges are closed; 0 closes none", {0, 100000});
  options->Add(group + "min_spike_factor", &cleaning.min_spike_factor,
               "Vertices that stand out alone, all their edges longer than this times the "
               "surface's edge length, sink to their neighbours; raising it keeps more of them. 0 "
               "keeps all.",
               {0.0, 1e6});
  options->Add(group + "smoothing_iterations", &cleaning.smoothing_iterations,
               "Steps of volume-preserving smoothing after the cut; 0 is off", {0, 1000});
  options->Add(
      group + "filter_levels", &filter_levels,
      "Coarser levels, each with about a 16th of the vertices of the one below, on which "
      "far outliers are dropped before the surface is made; 0 is off. Costs up to a tenth of "
      "the time each, and gains nothing on clouds of stereo_fusion; for clouds of other "
      "programs in which much floats far from all surfaces",
      {0, 4});
}

size_t EstimateVisibilityMesherVertices(const Scene& scene, size_t num_points, PointSpacing spacing,
                                        const VisibilityMesherOptions& options) {
  // A cell of max_proj_dist squared gets a vertex when so many points fall around it; measured on
  // clouds of 8 to 24 photos.
  constexpr double kRegularPoints = 0.95, kRandomPoints = 2.0;
  double num_pixels = 0;
  for (const View& view : scene.views) {
    num_pixels += static_cast<double>(view.camera.width) * view.camera.height;
  }
  const double side = std::max(options.merging.max_proj_dist, 1e-3);
  const double cells = num_pixels * EstimateSurfaceShare(scene).once / (side * side);
  if (!(cells > 0)) return num_points;
  const auto points = static_cast<double>(num_points);
  const double per_cell = spacing == PointSpacing::kRegular ? kRegularPoints : kRandomPoints;
  return static_cast<size_t>(std::min(points, -cells * std::expm1(-points / (per_cell * cells))));
}

MeshingSize EstimateMeshingSize(const Scene& scene, size_t num_points, size_t num_view_entries,
                                PointSpacing spacing, const VisibilityMesherOptions& options,
                                int num_threads) {
  // A vertex has the views of all points that it was merged from: measured 1.1 times those of one.
  constexpr double kSightsPerView = 1.1;
  MeshingSize size;
  size.num_points = num_points;
  size.num_view_entries = num_view_entries;
  size.num_vertices = EstimateVisibilityMesherVertices(scene, num_points, spacing, options);
  size.num_sights = static_cast<size_t>(kSightsPerView * static_cast<double>(num_view_entries) /
                                        std::max(1.0, static_cast<double>(num_points)) *
                                        static_cast<double>(size.num_vertices));
  size.num_threads = num_threads;
  return size;
}

namespace {

// In the cube of a place.
struct PlaceCounts {
  size_t num_points = 0, num_vertices = 0, num_sights = 0;
};

PlaceCounts CountInCube(const Scene& scene, const CloudSample::Place& place,
                        const PointMergingOptions& merging, const RunContext& context) {
  PlaceCounts counts;
  for (const Eigen::Vector3f& x : place.points.positions) {
    counts.num_points += place.cube.contains(x);
  }
  if (counts.num_points == 0) return counts;
  const MergedCloud merged = MergePoints(scene, place.points, merging, context);
  for (size_t v = 0; v < merged.positions.size(); ++v) {
    const Eigen::Vector3d x = merged.frame.ToWorld(merged.positions[v].cast<double>());
    if (!place.cube.contains(x.cast<float>())) continue;
    ++counts.num_vertices;
    counts.num_sights += merged.SightsOf(v).size();
  }
  return counts;
}

// Without views that the scene does not have, as a file of another model could name.
CloudSample::Place WithKnownViews(const CloudSample::Place& place, size_t num_views) {
  CloudSample::Place known{place.cube, {}};
  for (size_t p = 0; p < place.points.size(); ++p) {
    std::vector<uint32_t> views;
    for (const uint32_t view_idx : place.points.ViewsOf(p)) {
      if (view_idx < num_views) views.push_back(view_idx);
    }
    known.points.Add(place.points.positions[p], place.points.normals[p], place.points.colors[p],
                     views);
  }
  return known;
}

}  // namespace

MeshingSize MeasureMeshingSize(const Scene& scene, const CloudSample& sample,
                               const VisibilityMesherOptions& options, int num_threads) {
  const RunContext context(1);
  PlaceCounts sum;
  for (const CloudSample::Place& place : sample.places) {
    const PlaceCounts counts =
        CountInCube(scene, WithKnownViews(place, scene.views.size()), options.merging, context);
    sum.num_points += counts.num_points;
    sum.num_vertices += counts.num_vertices;
    sum.num_sights += counts.num_sights;
  }
  MeshingSize size;
  size.num_points = static_cast<size_t>(sample.num_points);
  size.num_view_entries = static_cast<size_t>(sample.num_view_entries);
  size.num_threads = num_threads;
  const double scale = static_cast<double>(size.num_points) /
                       static_cast<double>(std::max<size_t>(1, sum.num_points));
  size.num_vertices = static_cast<size_t>(scale * static_cast<double>(sum.num_vertices));
  size.num_sights = static_cast<size_t>(scale * static_cast<double>(sum.num_sights));
  return size;
}

CostEstimate EstimateVisibilityMesherCost(const MeshingSize& size) {
  CostEstimate estimate;
  // Microseconds: reading and merging a point; tetrahedra, rays, cut and cleaning of a vertex.
  estimate.cpu_seconds = 1e-6 * (1.6 * static_cast<double>(size.num_points) +
                                 30.0 * static_cast<double>(size.num_vertices));
  estimate.peak_bytes = size.CloudBytes() + size.PeakBytes();
  return estimate;
}

}  // namespace lsmvs
