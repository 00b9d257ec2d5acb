#include "lsmvs/surface/extraction/surface_cleaning.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "lsmvs/geometry/mean_longer_side.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/mesh/smoothing.h"
#include "lsmvs/mesh/spikes.h"
#include "lsmvs/mesh/surface_trimming.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

double LongestEdge(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3i& face) {
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    squared = std::max(squared, (vertices[face[k]] - vertices[face[(k + 1) % 3]]).squaredNorm());
  }
  return std::sqrt(squared);
}

class Cleaner {
 public:
  Cleaner(const Scene& scene, const MergedCloud& cloud, const SurfaceCleaningOptions& options,
          double visibility_sigma, const RunContext& context, ExtractedSurface* surface)
      : cloud_(cloud),
        options_(options),
        visibility_sigma_(visibility_sigma),
        context_(context),
        mesh_(surface->mesh),
        vertex_point_(surface->vertex_point),
        photo_size_(MeanLongerSide(scene.views)) {
    for (const View& view : scene.views) {
      centers_.push_back(cloud.frame.FromWorld(view.CenterInWorld()));
      focal_lengths_.push_back(view.camera.MeanFocalLength());
    }
  }

  SurfaceCleaningCounters Run() {
    MeasureLengths();
    MeasureFalseShare();
    Trim();
    // Before floating pieces are looked for, of which some hang on the rest by a vertex only.
    for (const int source : SplitNonManifoldVertices(&mesh_)) {
      vertex_point_.push_back(vertex_point_[source]);
      pixel_size_.push_back(pixel_size_[source]);
    }
    DropFloatingComponents();
    RemoveUnused();
    if (options_.max_hole_edges > 0) CloseSmallHoles();
    if (options_.min_spike_factor > 0) SinkLoneSpikes();
    counters_.num_components = FindComponents(mesh_).num_faces.size();
    SmoothTaubin({.num_iterations = options_.smoothing_iterations}, context_, &mesh_);
    SetColors();
    return counters_;
  }

 private:
  void MeasureLengths() {
    if (mesh_.faces.empty()) return;
    MeasurePixels();
    std::vector<double> in_pixels(mesh_.faces.size());
    for (size_t f = 0; f < in_pixels.size(); ++f) {
      in_pixels[f] = LongestEdge(mesh_.vertices, mesh_.faces[f]) / PixelSize(mesh_.faces[f]);
    }
    usual_pixels_ = Quantile(&in_pixels, options_.max_side_length_percentile / 100);
  }

  // What a pixel covers at each vertex, in the view that sees it finest; the middle of a split edge
  // has its neighbours'.
  void MeasurePixels() {
    pixel_size_.assign(mesh_.vertices.size(), 0);
    for (size_t v = 0; v < pixel_size_.size(); ++v) {
      if (vertex_point_[v] < 0) continue;
      double finest = std::numeric_limits<double>::infinity();
      for (const Sight& sight : cloud_.SightsOf(static_cast<size_t>(vertex_point_[v]))) {
        const double distance = (centers_[sight.view_idx] - mesh_.vertices[v]).norm();
        finest = std::min(finest, distance / focal_lengths_[sight.view_idx]);
      }
      pixel_size_[v] = finest;
    }
  }
  // The coarsest of its corners.
  double PixelSize(const Eigen::Vector3i& face) const {
    return std::max({pixel_size_[face[0]], pixel_size_[face[1]], pixel_size_[face[2]]});
  }

  // Vertices that a cut left off its surface were contradicted; among those on it, where no ray
  // tells, the share of false ones is taken to be the same.
  void MeasureFalseShare() {
    std::vector<char> on_surface(cloud_.colors.size(), 0);
    for (const int32_t point : vertex_point_) {
      if (point >= 0) on_surface[static_cast<size_t>(point)] = 1;
    }
    const auto num_true = std::count(on_surface.begin(), on_surface.end(), 1);
    const size_t num_all = on_surface.size() + cloud_.num_filtered_vertices;
    false_share_ = 1 - static_cast<double>(num_true) / static_cast<double>(num_all);
  }

  // By the evidence of each face alone, or of the surface as a whole.
  void Trim() {
    if (options_.max_side_length_factor <= 0 && options_.max_web_factor <= 0 &&
        options_.normal_check_factor <= 0) {
      return;
    }
    TrimmingProblem problem;
    problem.pixel_size = pixel_size_;
    problem.border_cost = options_.completeness == Completeness::kStrict ? 0.0 : 0.5 * MaxGap();
    problem.keep_gain.resize(mesh_.faces.size());
    ParallelFor(context_, mesh_.faces.size(), 1 << 13, [&](size_t f) {
      const double stress = std::clamp(Stress(mesh_.faces[f]), kLeastStress, 1 / kLeastStress);
      problem.keep_gain[f] = -std::log(stress) * AreaInPixels(f);
    });
    std::vector<uint8_t> kept = TrimSurface(mesh_, problem, context_);
    if (options_.completeness == Completeness::kClosed) {
      std::vector<uint8_t> visible(mesh_.faces.size());
      for (size_t f = 0; f < visible.size(); ++f) visible[f] = !kept[f] && FacesAView(f);
      KeepEnclosedFaces(mesh_, visible, &kept);
    }
    counters_.num_dropped_webs = FilterFaces(&mesh_, [&](size_t f) { return kept[f] != 0; });
  }

  bool FacesAView(size_t f) const {
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, f);
    const Eigen::Vector3d& corner = mesh_.vertices[mesh_.faces[f][0]];
    return std::any_of(centers_.begin(), centers_.end(),
                       [&](const auto& center) { return normal.dot(center - corner) > 0; });
  }

  // Pixels.
  double MaxGap() const { return options_.max_gap_share * photo_size_; }

  double AreaInPixels(size_t f) const {
    const double pixel = PixelSize(mesh_.faces[f]);
    // Never nothing, so that a face without area goes with its evidence.
    constexpr double kLeastArea = 0.1;
    const double area = 0.5 * FaceNormalTimesTwiceArea(mesh_, f).norm();
    return pixel > 0 ? std::max(area / (pixel * pixel), kLeastArea) : kLeastArea;
  }

  // How far a facet goes beyond what is believed of a surface: above 1 more speaks against it than
  // for it.
  double Stress(const Eigen::Vector3i& face) const {
    double stress = LengthStress(face);
    const bool measured =
        std::all_of(face.begin(), face.end(), [&](int v) { return vertex_point_[v] >= 0; });
    if (measured) stress = std::max({stress, NormalStress(face), SpanStress(face)});
    return stress;
  }

  double LengthStress(const Eigen::Vector3i& face) const {
    if (options_.max_side_length_factor <= 0) return 0;
    return LongestEdge(mesh_.vertices, face) /
           (options_.max_side_length_factor * UsualLength(face));
  }

  // Of long facets that defy the normals at their corners.
  double NormalStress(const Eigen::Vector3i& face) const {
    if (options_.normal_check_factor <= 0 || LeastCosine(face, 1) >= least_cosine_) return 0;
    const double limit =
        options_.normal_check_factor * UsualLength(face) * LeastTrust(face, false_share_);
    return LongestEdge(mesh_.vertices, face) / limit;
  }

  double SpanStress(const Eigen::Vector3i& face) const {
    if (options_.max_web_factor <= 0) return 0;
    const double trust = LeastTrust(face, std::max(false_share_, kLeastFalseShare));
    const double limit = options_.max_web_factor * UsualLength(face) * trust;
    const double length = LongestEdge(mesh_.vertices, face);
    // The rest costs a look at every view.
    const double most = (1 + kDepthStress) * length * kMaxTurn;
    if (most <= kLeastStress * limit) return most / limit;
    const double turn = std::max(kMinTurn, std::sqrt(1 - LeastCosine(face, kUnknownCosine)));
    return (length + kDepthStress * LeastDepthExtent(face)) * turn / limit;
  }

  // Of the angles to the normals that the points at the corners had; `unknown` where they had none.
  double LeastCosine(const Eigen::Vector3i& face, double unknown) const {
    const Eigen::Vector3d& corner = mesh_.vertices[face[0]];
    const Eigen::Vector3d normal =
        (mesh_.vertices[face[1]] - corner).cross(mesh_.vertices[face[2]] - corner).normalized();
    double least = 1;
    for (const int v : face) {
      const Eigen::Vector3f& measured = cloud_.normals[vertex_point_[v]];
      least =
          std::min(least, measured.isZero(0.0f) ? unknown : measured.cast<double>().dot(normal));
    }
    return least;
  }

  // How far the corner that the fewest views saw can be trusted, 0 to 1: the share of true ones
  // among edges whose ends have its confidence, where a share `false_share` of the vertices is not;
  // to the third, all corners being wrong together, so that between the least trusted ones facets
  // of any length are checked.
  double LeastTrust(const Eigen::Vector3i& face, double false_share) const {
    size_t num_views = std::numeric_limits<size_t>::max();
    for (const int v : face) {
      num_views =
          std::min(num_views, cloud_.SightsOf(static_cast<size_t>(vertex_point_[v])).size());
    }
    const double confidence = ViewConfidence(num_views, visibility_sigma_);
    const double for_true = (1 - false_share) * confidence * confidence;
    const double for_false = false_share * (1 - confidence * confidence);
    const double trust = for_true / (for_true + for_false);
    return trust * trust * trust;
  }

  // How far the face reaches along the line of sight of the view in which that is least, among
  // those that see a corner and look at its front; 0 if there is none.
  double LeastDepthExtent(const Eigen::Vector3i& face) const {
    const std::array<Eigen::Vector3d, 3> x = {mesh_.vertices[face[0]], mesh_.vertices[face[1]],
                                              mesh_.vertices[face[2]]};
    const Eigen::Vector3d middle = (x[0] + x[1] + x[2]) / 3,
                          normal = (x[1] - x[0]).cross(x[2] - x[0]);
    double least = std::numeric_limits<double>::infinity();
    for (const int v : face) {
      for (const Sight& sight : cloud_.SightsOf(static_cast<size_t>(vertex_point_[v]))) {
        const Eigen::Vector3d to_view = centers_[sight.view_idx] - middle;
        if (to_view.dot(normal) <= 0) continue;
        const Eigen::Vector3d ray = to_view.normalized();
        const auto [low, high] =
            std::minmax({ray.dot(x[0] - middle), ray.dot(x[1] - middle), ray.dot(x[2] - middle)});
        least = std::min(least, high - low);
      }
    }
    return std::isfinite(least) ? least : 0;
  }

  // Of an edge where the face is.
  double UsualLength(const Eigen::Vector3i& face) const { return usual_pixels_ * PixelSize(face); }

  void DropFloatingComponents() {
    const MeshComponents components = FindComponents(mesh_);
    if (components.num_faces.empty()) return;
    const size_t largest =
        *std::max_element(components.num_faces.begin(), components.num_faces.end());
    const double least =
        std::max<double>(options_.min_component_faces,
                         options_.min_component_fraction * static_cast<double>(largest));
    const auto keep = [&](int component) {
      const size_t size = components.num_faces[component];
      return size == largest || static_cast<double>(size) >= least;
    };
    for (size_t c = 0; c < components.num_faces.size(); ++c) {
      counters_.num_dropped_components += !keep(static_cast<int>(c));
    }
    counters_.num_dropped_component_faces =
        FilterFaces(&mesh_, [&](size_t f) { return keep(components.of_face[f]); });
  }

  void RemoveUnused() {
    const std::vector<int> new_index = RemoveUnusedVertices(&mesh_);
    for (size_t v = 0; v < new_index.size(); ++v) {
      if (new_index[v] < 0) continue;
      vertex_point_[new_index[v]] = vertex_point_[v];
      pixel_size_[new_index[v]] = pixel_size_[v];
    }
    vertex_point_.resize(mesh_.vertices.size());
    pixel_size_.resize(mesh_.vertices.size());
  }

  void CloseSmallHoles() {
    HoleClosingOptions closing;
    closing.max_num_edges = options_.max_hole_edges;
    if (options_.completeness == Completeness::kStrict) {
      closing.accept = [&](const Eigen::Vector3i& face) { return Stress(face) <= 1; };
    }
    counters_.num_closed_holes = CloseHoles(closing, context_, &mesh_);
  }

  void SinkLoneSpikes() {
    std::vector<double> least_edges(mesh_.vertices.size());
    for (size_t v = 0; v < least_edges.size(); ++v) {
      // The middles of split edges have no size.
      least_edges[v] = pixel_size_[v] > 0
                           ? options_.min_spike_factor * usual_pixels_ * pixel_size_[v]
                           : std::numeric_limits<double>::infinity();
    }
    const std::vector<int32_t> sunk = SinkSpikes(least_edges, context_, &mesh_);
    for (const int32_t v : sunk) vertex_point_[v] = -1;  // its views saw another place
    counters_.num_sunk_spikes = sunk.size();
  }

  void SetColors() {
    mesh_.vertex_colors.assign(mesh_.vertices.size(), Color::Zero());
    for (size_t v = 0; v < vertex_point_.size(); ++v) {
      if (vertex_point_[v] >= 0) mesh_.vertex_colors[v] = cloud_.colors[vertex_point_[v]];
    }
    ColorOthers();
  }

  // Vertices that are no points take the mean colour of their neighbours that are.
  void ColorOthers() {
    if (std::find(vertex_point_.begin(), vertex_point_.end(), -1) == vertex_point_.end()) return;
    std::vector<Eigen::Vector3i> sums(mesh_.vertices.size(), Eigen::Vector3i::Zero());
    std::vector<int> counts(mesh_.vertices.size(), 0);
    for (const Eigen::Vector3i& face : mesh_.faces) {
      for (int k = 0; k < 3; ++k) {
        const int v = face[k], next = face[(k + 1) % 3];
        if (vertex_point_[v] >= 0 || vertex_point_[next] < 0) continue;
        sums[v] += mesh_.vertex_colors[next].cast<int>();
        ++counts[v];
      }
    }
    for (size_t v = 0; v < counts.size(); ++v) {
      if (counts[v] > 0) mesh_.vertex_colors[v] = (sums[v] / counts[v]).cast<uint8_t>();
    }
  }

  const MergedCloud& cloud_;
  const SurfaceCleaningOptions& options_;
  const double visibility_sigma_;
  const RunContext& context_;
  // What a facet's depth weighs against its length; the range of sqrt(1 - cosine).
  static constexpr double kDepthStress = 8, kMinTurn = 0.14, kMaxTurn = std::numbers::sqrt2;
  static constexpr double kUnknownCosine = 0.5;
  // Where webs hang, no ray tells: more is false there than the cut found.
  static constexpr double kLeastFalseShare = 0.1;
  // Evidence is cut here, on both sides: the rule is no measurement, and no facet may outweigh all
  // others.
  static constexpr double kLeastStress = 0.135;

  std::vector<Eigen::Vector3d> centers_;  // of the views, canonical
  std::vector<double> focal_lengths_;     // of the views, pixels
  TriangleMesh& mesh_;
  std::vector<int32_t>& vertex_point_;
  const double photo_size_;  // mean longer side of the views, pixels
  const double least_cosine_ = std::cos(options_.max_normal_angle_deg * std::numbers::pi / 180);
  std::vector<double> pixel_size_;  // by mesh vertex
  double usual_pixels_ = 0;         // length of the surface's edges
  double false_share_ = 0;          // of the cloud's vertices
  SurfaceCleaningCounters counters_;
};

}  // namespace

SurfaceCleaningCounters CleanSurface(const Scene& scene, const MergedCloud& cloud,
                                     const SurfaceCleaningOptions& options, double visibility_sigma,
                                     const RunContext& context, ExtractedSurface* surface) {
  return Cleaner(scene, cloud, options, visibility_sigma, context, surface).Run();
}

}  // namespace lsmvs
