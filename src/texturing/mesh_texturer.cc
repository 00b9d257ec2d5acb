#include "lsmvs/texturing/mesh_texturer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/image/largest_image.h"
#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/texturing/baking/page_baker.h"
#include "lsmvs/texturing/candidates/find_candidates.h"
#include "lsmvs/texturing/candidates/split_faces.h"
#include "lsmvs/texturing/charts/charts.h"
#include "lsmvs/texturing/charts/packing.h"
#include "lsmvs/texturing/exposure/exposure_gains.h"
#include "lsmvs/texturing/labels/alpha_expansion.h"
#include "lsmvs/texturing/labels/ghosts.h"
#include "lsmvs/texturing/labels/guests.h"
#include "lsmvs/texturing/labels/islands.h"
#include "lsmvs/texturing/levelling/seam_levelling.h"
#include "lsmvs/texturing/unseen/fill_colors.h"
#include "lsmvs/texturing/unseen/unseen_color.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

constexpr double kMinIslandArea_px = 64;
// Unseen faces get texels of this part of the density of seen ones, and this part of their texels
// at most.
constexpr double kUnseenDensity = 0.25, kUnseenShare = 0.02;
// Around their charts, whose colours are smooth.
constexpr int kUnseenPadding = 1;
// Progress at the end of the phases.
constexpr double kAfterCandidates = 0.35, kAfterLabels = 0.7, kAfterLevelling = 0.75;

// Texels of faces without a photo are laid out along the axis that they face most.
int AxisOf(const TriangleMesh& mesh, size_t face) {
  const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, face);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<int>(axis) + (normal[axis] > 0 ? 1 : 0);
}

// The steps: per face the photos that show it (FindCandidates); gains of
// exposure (EstimateExposureGains); ghosts are left out (DropGhosts); one photo per face by a graph
// cut (ExpandLabels, AbsorbIslands); seams levelled (LevelSeams) and faded; charts of connected
// faces of a photo packed on pages (MakeCharts, PackRectangles); pages baked one by one (BakePage),
// each handed to `write_page` and forgotten.
class MeshTexturer {
 public:
  MeshTexturer(const Scene& scene, const ImageStore& images, TriangleMesh mesh,
               const MeshTexturerOptions& options, const RunContext& context)
      : scene_(scene),
        images_(images),
        options_(options),
        context_(context),
        mesh_(std::move(mesh)),
        neighbors_(FindFaceNeighbors(mesh_.faces, mesh_.vertices.size())),
        candidates_(0, 1),
        energy_(mesh_, neighbors_, candidates_, options.seam_cost) {}

  TexturingResult Run(const std::string& mesh_name, const PageSink& write_page) {
    FindViews(mesh_name);
    ChooseViews();
    Level();
    MakeAtlas();
    BakePages(write_page);
    Finish();
    return std::move(result_);
  }

 private:
  void FindViews(const std::string& mesh_name) {
    const PhaseTimer timer("candidates", &result_.seconds);
    candidates_ = FindCandidates(scene_, images_, mesh_, options_.max_num_views,
                                 context_.Part(0, kAfterCandidates));
    const size_t num_faces = mesh_.faces.size();
    for (size_t f = 0; f < num_faces; ++f) result_.num_faces_unseen += candidates_.Of(f).empty();
    if (result_.num_faces_unseen == num_faces) {
      throw InputError(mesh_name, "no photo shows any of its faces",
                       "check that mesh and workspace have the same coordinates, that faces are "
                       "counter-clockwise seen from outside, and the masks");
    }
    appearance_.gains.assign(scene_.views.size(), Eigen::Vector3f::Ones());
    if (options_.apply_color_correction) {
      const ExposureGains gains = EstimateExposureGains(candidates_, scene_.views.size());
      ApplyExposureGains(gains, &candidates_);
      appearance_.gains = gains.factors;
      result_.gains_used = gains.is_used;
    }
    if (options_.reject_ghosts) result_.num_ghosts = DropGhosts(neighbors_, &candidates_, context_);
  }

  void ChooseViews() {
    const PhaseTimer timer("labels", &result_.seconds);
    ViewSlots slots = BestSlots(candidates_);
    ExpandLabels(energy_, {}, &slots, context_.Part(kAfterCandidates, kAfterLabels));
    AbsorbIslands(energy_, kMinIslandArea_px, &slots);
    views_.resize(slots.size());
    for (size_t f = 0; f < slots.size(); ++f) views_[f] = energy_.ViewOf(slots, f);
    guest_of_ = FindGuests(scene_, energy_, &views_);
    appearance_.views = views_;
  }

  void Level() {
    const PhaseTimer timer("levelling", &result_.seconds);
    appearance_.nodes = FindLabelNodes(mesh_.faces, mesh_.vertices.size(), views_);
    const std::vector<SeamPair> pairs = FindSeamPairs(energy_, appearance_.nodes);
    appearance_.offsets.assign(appearance_.nodes.size(), Eigen::Vector3f::Zero());
    if (options_.apply_color_correction && !pairs.empty()) {
      appearance_.offsets = LevelSeams(energy_, appearance_.nodes, pairs, {});
    }
    appearance_.fades =
        FindSeamFades(energy_, appearance_.nodes, appearance_.offsets, options_.fade_width);
    if (result_.num_faces_unseen == 0) return;
    if (options_.unseen == UnseenFaces::kFill) {
      appearance_.fill_colors =
          HarmonicFillColors(energy_, views_, appearance_.nodes, appearance_.offsets);
    } else {
      const Color color = *ParseUnseenColor(options_.unseen_color);
      appearance_.fill_colors.assign(mesh_.vertices.size(), color.cast<float>());
    }
    context_.Report(kAfterLevelling);
  }

  // Texels per pixel of the photo.
  double ScaleOf(int32_t view_idx, std::span<const uint32_t> faces) const {
    if (!(options_.texel_size > 0)) return options_.texture_scale_factor;
    const View& view = scene_.views[static_cast<size_t>(view_idx)];
    double area = 0, depth_sum = 0;
    for (const uint32_t f : faces) {
      const double weight = FaceNormalTimesTwiceArea(mesh_, f).norm();
      area += weight;
      depth_sum += weight * view.Depth(mesh_.vertices[mesh_.faces[f][0]]);
    }
    const double pixels_per_unit =
        images_.Camera(view_idx, 0).MeanFocalLength() * area / std::max(1e-300, depth_sum);
    return std::min(options_.texture_scale_factor, 1 / (options_.texel_size * pixels_per_unit));
  }

  // Less where a single face would be larger than a page.
  double FittingScale(int32_t view_idx, std::span<const uint32_t> faces) const {
    const View& view = scene_.views[static_cast<size_t>(view_idx)];
    const ChartMap map = ChartMap::OfPhoto(images_.Camera(view_idx, 0), view.cam_from_world, 1);
    double largest_px = 0;
    for (const uint32_t f : faces) {
      Eigen::AlignedBox2d box;
      for (const int v : mesh_.faces[f]) box.extend(map(mesh_.vertices[v]));
      largest_px = std::max(largest_px, box.sizes().maxCoeff());
    }
    const double room = options_.max_page_size - 2 * options_.atlas_patch_padding - 2;
    return std::min(ScaleOf(view_idx, faces), room / std::max(1e-300, largest_px));
  }

  ChartLayout LayoutOf(int32_t label, std::span<const uint32_t> faces) const {
    const auto num_views = static_cast<int32_t>(scene_.views.size());
    if (label >= num_views) {
      const int axis = label - num_views;
      return {ChartMap::OfAxis(axis / 2, axis % 2 == 1, unseen_density_), 0, kUnseenPadding};
    }
    const double scale = FittingScale(label, faces);
    const View& view = scene_.views[static_cast<size_t>(label)];
    const int level = std::clamp(static_cast<int>(std::floor(-std::log2(scale))), 0, 16);
    return {ChartMap::OfPhoto(images_.Camera(label, 0), view.cam_from_world, scale), level,
            options_.atlas_patch_padding};
  }

  // Views, then the axes that unseen faces face; -1 for those that are dropped.
  std::vector<int32_t> ChartLabels() const {
    std::vector<int32_t> labels = views_;
    for (size_t f = 0; f < labels.size(); ++f) {
      if (guest_of_[f] >= 0) labels[f] = guest_of_[f];
      if (labels[f] >= 0 || options_.unseen == UnseenFaces::kDrop) continue;
      labels[f] = static_cast<int32_t>(scene_.views.size()) + AxisOf(mesh_, f);
    }
    return labels;
  }

  void MeasureUnseen() {
    double seen_area = 0, seen_texels = 0, unseen_area = 0;
    for (size_t f = 0; f < views_.size(); ++f) {
      const double area = 0.5 * FaceNormalTimesTwiceArea(mesh_, f).norm();
      (views_[f] < 0 ? unseen_area : seen_area) += area;
      seen_texels += energy_.AreaPx(f) * std::pow(options_.texture_scale_factor, 2);
    }
    result_.unseen_area_share = unseen_area / std::max(1e-300, seen_area + unseen_area);
    const double density = kUnseenDensity * std::sqrt(seen_texels / std::max(1e-300, seen_area));
    unseen_density_ = density;
    if (unseen_area > 0) {
      unseen_density_ = std::min(density, std::sqrt(kUnseenShare * seen_texels / unseen_area));
    }
  }

  void MakeAtlas() {
    const PhaseTimer timer("charts", &result_.seconds);
    MeasureUnseen();
    charts_ = MakeCharts(
        mesh_, neighbors_, ChartLabels(), options_.max_page_size,
        [&](int32_t label, std::span<const uint32_t> faces) { return LayoutOf(label, faces); });
    std::vector<Eigen::Vector2i> sizes;
    std::vector<Eigen::Vector3d> places;
    for (const Chart& chart : charts_.charts) {
      sizes.push_back(chart.size);
      const uint32_t middle = charts_.faces[(chart.begin + chart.end) / 2];
      places.push_back(mesh_.vertices[mesh_.faces[middle][0]]);
    }
    const Packing packing = PackRectangles(sizes, HilbertOrder(places), options_.max_page_size);
    for (size_t c = 0; c < charts_.charts.size(); ++c) {
      charts_.charts[c].page_idx = packing.page_idx[c];
      charts_.charts[c].position = packing.position[c];
    }
    num_pages_ = packing.num_pages;
    page_side_ = packing.page_side;
    result_.num_charts = charts_.charts.size();
  }

  void BakePages(const PageSink& write_page) {
    const PhaseTimer timer("baking", &result_.seconds);
    size_t num_used = 0;
    for (int p = 0; p < num_pages_; ++p) {
      context_.ThrowIfCancelled();
      BakedPage page =
          BakePage(scene_, images_, energy_, appearance_, charts_, p, page_side_, context_);
      num_used += static_cast<size_t>(
          std::count(page.coverage.pixels.begin(), page.coverage.pixels.end(), 2));
      page.coverage = {};
      result_.textured.pages.push_back(write_page(p, std::move(page.colors)));
      context_.Report(kAfterLevelling + (1 - kAfterLevelling) * (p + 1) / num_pages_);
    }
    const double texels = static_cast<double>(num_pages_) * page_side_ * page_side_;
    result_.utilisation = static_cast<double>(num_used) / texels;
  }

  void Finish() {
    TexturedMesh& textured = result_.textured;
    textured.page_width = textured.page_height = page_side_;
    std::vector<uint32_t> chart_of(mesh_.faces.size(), 0);
    std::vector<bool> is_kept(mesh_.faces.size(), false);
    for (uint32_t c = 0; c < charts_.charts.size(); ++c) {
      for (const uint32_t f : charts_.FacesOf(charts_.charts[c])) {
        chart_of[f] = c;
        is_kept[f] = true;
      }
    }
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (!is_kept[f]) continue;
      textured.texcoords.push_back(TexcoordsOf(f, charts_.charts[chart_of[f]]));
      textured.page_idx.push_back(charts_.charts[chart_of[f]].page_idx);
    }
    textured.mesh = std::move(mesh_);
    textured.mesh.vertex_colors.clear();
    FilterFaces(&textured.mesh, [&](size_t f) { return is_kept[f]; });
    RemoveUnusedVertices(&textured.mesh);
  }

  // On its page, not outside by rounding.
  std::array<Eigen::Vector2f, 3> TexcoordsOf(size_t face, const Chart& chart) const {
    std::array<Eigen::Vector2f, 3> corners;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d x = chart.map(mesh_.vertices[mesh_.faces[face][k]]) +
                                (chart.position - chart.origin).cast<double>();
      corners[static_cast<size_t>(k)] = x.cwiseMax(0.0).cwiseMin(page_side_).cast<float>();
    }
    return corners;
  }

  const Scene& scene_;
  const ImageStore& images_;
  const MeshTexturerOptions& options_;
  const RunContext& context_;
  TriangleMesh mesh_;
  FaceNeighbors neighbors_;
  FaceCandidates candidates_;
  LabelEnergy energy_;
  std::vector<int32_t> views_, guest_of_;
  SurfaceAppearance appearance_;
  double unseen_density_ = 0;
  Charts charts_;
  int num_pages_ = 0, page_side_ = 0;
  TexturingResult result_;
};

}  // namespace

TexturingResult TextureMesh(const Scene& scene, const ImageStore& images, TriangleMesh mesh,
                            const std::string& mesh_name, const MeshTexturerOptions& options,
                            const PageSink& write_page, const RunContext& context) {
  RequireValid(options);
  if (mesh.faces.empty()) throw InputError(mesh_name, "has no faces", "give a mesh");
  if (options.max_face_width > 0)
    SplitWideFaces(scene, images, options.max_face_width, &mesh, context);
  return MeshTexturer(scene, images, std::move(mesh), options, context).Run(mesh_name, write_page);
}

double ExpectedTexels(const ImageStore& images, double views_per_point,
                      const MeshTexturerOptions& options) {
  double pixels = 0;
  for (size_t v = 0; v < images.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(static_cast<int>(v), 0);
    pixels += static_cast<double>(camera.width) * camera.height;
  }
  // Of the views of a point, the texture takes the one that shows it largest.
  constexpr double kLargerThanMean = 1.5, kUtilisation = 0.6;
  return kLargerThanMean / kUtilisation * pixels / std::max(1.0, views_per_point) *
         std::pow(options.texture_scale_factor, 2);
}

CostEstimate EstimateTexturingCost(const ImageStore& images, size_t num_faces,
                                   const MeshTexturerOptions& options, int num_threads) {
  constexpr double kBytesPerFace = 300, kBytesPerPixelOfThread = 12, kBytesPerTexel = 8;
  constexpr double kSecondsPerFace = 3e-5, kSecondsPerPixel = 4e-7;
  const auto pixels = static_cast<double>(LargestImagePixels(images));
  double all_pixels = 0;
  for (size_t v = 0; v < images.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(static_cast<int>(v), 0);
    all_pixels += static_cast<double>(camera.width) * camera.height;
  }
  const double page = std::min(std::pow(options.max_page_size, 2),
                               2 * all_pixels * std::pow(options.texture_scale_factor, 2));
  CostEstimate cost;
  cost.peak_bytes = static_cast<size_t>(
      kBytesPerFace * static_cast<double>(num_faces) +
      std::max(kBytesPerTexel * page, kBytesPerPixelOfThread * num_threads * pixels));
  cost.cpu_seconds =
      kSecondsPerFace * static_cast<double>(num_faces) + kSecondsPerPixel * all_pixels;
  return cost;
}

}  // namespace lsmvs
