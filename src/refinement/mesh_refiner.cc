#include "lsmvs/refinement/mesh_refiner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "lsmvs/geometry/mean_longer_side.h"
#include "lsmvs/image/largest_image.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/refinement/finishing/finishing.h"
#include "lsmvs/refinement/finishing/region_rollback.h"
#include "lsmvs/refinement/finishing/vertex_quality.h"
#include "lsmvs/refinement/regions/refinement_checkpoints.h"
#include "lsmvs/refinement/step/crease_weights.h"
#include "lsmvs/refinement/step/level_optimizer.h"
#include "lsmvs/refinement/step/mesh_adaptation.h"
#include "lsmvs/refinement/step/noise_filter.h"
#include "lsmvs/refinement/step/smoothness.h"
#include "lsmvs/refinement/step/vertex_frames.h"
#include "lsmvs/refinement/vertex_pixel_sizes.h"
#include "lsmvs/scene/surface_share.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/texturing/vertex_colors.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/scratch_memory.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

constexpr int kMinLevelSize = 64;
constexpr int kFacesPerRegion = 256;
// A mesh with more faces is put in an order in which a part of it at a time is needed.
constexpr size_t kFacesToOrder = 1 << 16;
// Smaller for the guard, which takes back whole regions.
constexpr int kFacesPerGuardRegion = 64;
// For progress, measured: what a level takes of the time of the coarser one (fewer regions still
// move, but there are four times the pixels), the part of a level before its first step, and what
// the guard, simplification and vertex colours take, in units of the coarsest level.
constexpr double kLevelCostRatio = 0.75, kPartBeforeSteps = 0.3;
constexpr double kGuardCost = 0.4, kSimplifyCost = 0.5, kColorCost = 0.15;

// Measured on scenes of 11 to 24 photos.
constexpr double kSecondsPerPixel = 1.5e-7, kSecondsPerFace = 4e-6;  // for each evaluation
constexpr double kSecondsPerPixelOnce = 2e-7;                        // decoding, colours
constexpr double kLevelSum = 1.33;  // pixels of all levels, relative to the finest
// Of a dense mesh short edges are collapsed until a face covers so many pixels, or until so large a
// part is left, since what is not flat must stay.
constexpr double kPixelsOfFace = 3.8, kPartThatStays = 0.25;
// The guard looks for pairs that took no part among more neighbours than the refinement had.
constexpr int kGuardNeighborFactor = 2, kMaxGuardPairs = 4;

std::vector<uint8_t> HeldOut(int num_views, int every) {
  std::vector<uint8_t> held_out(static_cast<size_t>(num_views), 0);
  for (int v = every; every > 0 && v <= num_views; v += every) {
    held_out[static_cast<size_t>(v - 1)] = 1;
  }
  return held_out;
}

// Ordered pairs of each view and its best neighbours, sorted. Held-out views take no part, or all
// if there are none.
std::vector<ViewPair> NeighborPairs(const Scene& scene, const MeshRefinerOptions& options,
                                    int max_num_neighbors, const std::vector<uint8_t>& held_out,
                                    const RunContext& context) {
  ViewSelectionOptions selection;
  // Enough that the neighbours that take part are as many as asked for.
  selection.max_num_neighbors =
      options.hold_out_every > 0 ? 2 * max_num_neighbors : max_num_neighbors;
  selection.min_triangulation_angle_deg = options.min_triangulation_angle_deg / 2;
  selection.max_triangulation_angle_deg =
      std::max(options.max_triangulation_angle_deg, selection.min_triangulation_angle_deg);
  const auto neighbors = SelectNeighbors(scene, selection, context);
  std::vector<ViewPair> pairs;
  for (int i = 0; i < scene.num_views(); ++i) {
    int taken = 0;
    for (const Neighbor& neighbor : neighbors[static_cast<size_t>(i)]) {
      const int j = neighbor.view_idx;
      if (held_out[static_cast<size_t>(i)] || held_out[static_cast<size_t>(j)]) continue;
      if (++taken <= max_num_neighbors) pairs.push_back({i, j});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const ViewPair& a, const ViewPair& b) {
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
  return pairs;
}

PairSelectionOptions MakePairSelectionOptions(const MeshRefinerOptions& options,
                                              const RunContext& context) {
  PairSelectionOptions result;
  result.max_pairs_per_face = options.max_pairs_per_face;
  result.min_angle_deg = options.min_triangulation_angle_deg;
  result.max_angle_deg = options.max_triangulation_angle_deg;
  result.depth_tolerance = options.depth_tolerance;
  result.map_budget_bytes = context.memory_budget_bytes / 4;
  return result;
}

// Levels from coarse to fine whose images are large enough.
std::vector<int> Levels(const ImageStore& images, const MeshRefinerOptions& options) {
  int longest = 0;
  for (size_t v = 0; v < images.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(static_cast<int>(v), 0);
    longest = std::max(longest, std::max(camera.width, camera.height));
  }
  std::vector<int> levels;
  for (int level = options.num_levels - 1; level >= 0; --level) {
    if (level == 0 || (longest >> level) >= kMinLevelSize) levels.push_back(level);
  }
  return levels;
}

class MeshRefiner {
 public:
  MeshRefiner(const Scene& scene, const ImageStore& images, const MeshRefinerOptions& options,
              const RunContext& context, const CheckpointFolder& checkpoints)
      : scene_(scene),
        images_(images),
        options_(options),
        context_(context),
        checkpoints_(checkpoints) {}

  RefinementResult Run(TriangleMesh&& mesh) {
    const Stopwatch stopwatch;
    result_.mesh.vertices = std::move(mesh.vertices);
    result_.mesh.faces = std::move(mesh.faces);
    mesh = {};  // what else it has is not needed
    input_ = result_.mesh.vertices;
    candidates_ = NeighborPairs(scene_, options_, options_.max_num_neighbors,
                                HeldOut(scene_.num_views(), options_.hold_out_every), context_);
    result_.num_pairs = static_cast<int>(candidates_.size());
    result_.prepare_seconds = stopwatch.Seconds();
    if (candidates_.empty()) {
      GiveUp("no two photos overlap at a useful angle; the mesh is as it was");
    } else if (result_.mesh.faces.empty()) {
      GiveUp("the mesh has no faces");
    } else {
      RefineLevels();
    }
    if (options_.color_vertices) Color();
    context_.Report(1.0);
    return std::move(result_);
  }

 private:
  void GiveUp(const std::string& why) {
    result_.status = RefinementStatus::kUnchanged;
    result_.message = why;
  }

  void RefineLevels() {
    if (result_.mesh.faces.size() > kFacesToOrder) OrderAlongCurve(&result_.mesh, &input_);
    const std::vector<int> levels = Levels(images_, options_);
    double done = 0, all = kGuardCost + kSimplifyCost + kColorCost;
    for (size_t k = 0; k < levels.size(); ++k) all += std::pow(kLevelCostRatio, k);
    const int num_found = checkpoints_.HasJudged()
                              ? static_cast<int>(levels.size())
                              : checkpoints_.NumLevels(static_cast<int>(levels.size()));
    result_.num_steps_found = static_cast<size_t>(num_found) + (checkpoints_.HasJudged() ? 1 : 0);
    if (num_found > 0 && !checkpoints_.HasJudged()) checkpoints_.ReadLevel(num_found - 1, State());
    for (int k = 0; k < static_cast<int>(levels.size()); ++k) {
      const double cost = std::pow(kLevelCostRatio, k);
      if (k >= num_found) {
        const RunContext context = context_.Part(done / all, (done + cost) / all);
        if (!RefineLevel(levels[static_cast<size_t>(k)], k == 0, context)) {
          return GiveUp("no pair of photos sees the mesh; it is as it was");
        }
        checkpoints_.WriteLevel(k, State());
      }
      done += cost;
    }
    if (checkpoints_.HasJudged()) {
      checkpoints_.ReadJudged(&result_);
    } else {
      FilterSeen(options_.result_filter_passes);
      JudgeAndFinish();
      result_.num_faces_refined = result_.mesh.faces.size();
      checkpoints_.WriteJudged(result_);
    }
    context_.Report((done + kGuardCost) / all);
    if (options_.simplify_tolerance > 0) {
      Simplify(context_.Part((done + kGuardCost) / all, (done + kGuardCost + kSimplifyCost) / all));
    }
    result_.message =
        fmt::format("{} of {} faces, photo error {:.4f} -> {:.4f}, {} of {} regions restored",
                    result_.mesh.faces.size(), result_.num_faces_refined, result_.input_photo_error,
                    result_.output_photo_error, result_.num_regions_restored, result_.num_regions);
  }

  RefinementState State() { return {&result_.mesh, &input_, &pairs_, &result_}; }

  // Takes noise off what pairs see, where triangles are smaller than half a window: clouds give
  // edges of 2 to 3 pixels, and coarser meshes have their shape on purpose.
  void FilterSeen(int num_passes) {
    if (num_passes == 0) return;
    const Stopwatch stopwatch;
    std::vector<double> pixel_size =
        VertexPixelSizes(result_.mesh, MakeLevelViews(scene_, images_, 0), context_);
    std::vector<uint8_t> is_seen(pixel_size.size(), 0);
    for (size_t f = 0; f < result_.mesh.faces.size(); ++f) {
      if (!pairs_.Seen(f)) continue;
      for (const int v : result_.mesh.faces[f]) is_seen[static_cast<size_t>(v)] = 1;
    }
    for (size_t v = 0; v < is_seen.size(); ++v) {
      if (!is_seen[v]) pixel_size[v] = 0;
    }
    FilterNoise(num_passes, options_.window_radius + 0.5, pixel_size, &result_.mesh, context_);
    result_.filter_seconds += stopwatch.Seconds();
  }

  // False if no pair sees any face.
  bool RefineLevel(int level, bool is_first, const RunContext& context) {
    const Stopwatch stopwatch;
    images_.Trim(0);
    const auto views = MakeLevelViews(scene_, images_, level);
    SelectPairs(views, context);
    // Triangles get the size that the mesh as it came asks for: of the filtered one, whose faces
    // look larger to the pairs, more would be collapsed than thin sheets bear.
    const bool is_filtered = is_first && options_.input_filter_passes > 0;
    if (is_filtered) {
      FilterSeen(options_.input_filter_passes);
      input_ = result_.mesh.vertices;
    }
    if (AdaptToPairs(is_first) || is_filtered) SelectPairs(views, context);
    ReturnFreedMemory();
    size_t num_seen = 0;
    for (size_t f = 0; f < result_.mesh.faces.size(); ++f) num_seen += pairs_.Seen(f);
    if (is_first) result_.num_faces_seen = num_seen;
    if (num_seen == 0) return false;
    context.Report(kPartBeforeSteps);
    result_.levels.push_back(OptimizeLevel(images_, views, regions_, pairs_, input_, options_,
                                           level, &result_.mesh,
                                           context.Part(kPartBeforeSteps, 1)));
    result_.levels.back().seconds = stopwatch.Seconds();
    result_.optimize_seconds += result_.levels.back().seconds;
    return true;
  }

  void SelectPairs(const std::vector<PosedCamera>& views, const RunContext& context) {
    const Stopwatch stopwatch;
    regions_ = GrowFaceRegions(result_.mesh, kFacesPerRegion);
    pairs_ = SelectFacePairs(views, candidates_, result_.mesh, regions_,
                             MakePairSelectionOptions(options_, context_), context);
    result_.prepare_seconds += stopwatch.Seconds();
  }

  // Brings the triangles to the resolution of the present pairs; thins out only what came in. True
  // if anything changed.
  bool AdaptToPairs(bool may_collapse) {
    if (options_.max_face_area_px == 0 && !options_.improve_mesh) return false;
    const Stopwatch stopwatch;
    std::vector<float> density(result_.mesh.faces.size(), 0.0f);
    for (size_t f = 0; f < density.size(); ++f) {
      const double area = 0.5 * FaceNormalTimesTwiceArea(result_.mesh, f).norm();
      if (area > 0) density[f] = static_cast<float>(pairs_.area_px[f] / area);
    }
    const MeshAdaptation changes = AdaptMesh(
        {options_.max_face_area_px, options_.improve_mesh && may_collapse, options_.improve_mesh},
        density, &result_.mesh, &input_, context_);
    result_.num_collapses += changes.num_collapses;
    result_.num_splits += changes.num_splits;
    result_.num_flips += changes.num_flips;
    if (changes.Any()) {
      OrderByRegions(GrowFaceRegions(result_.mesh, kFacesPerRegion), &result_.mesh, &input_);
    }
    result_.remesh_seconds += stopwatch.Seconds();
    return changes.Any();
  }

  // By pairs that took no part where there are any.
  void JudgeAndFinish() {
    const Stopwatch stopwatch;
    const auto views = MakeLevelViews(scene_, images_, 0);
    const FacePairs pairs = SelectJudges(views);
    const PhotoEnergyOptions energy = MakePhotoEnergyOptions(options_, 0, context_);
    PhotoTerms terms;
    if (options_.guard) {
      terms = Guard(views, pairs, energy);
    } else if (options_.max_gap_share > 0) {
      terms = EvaluatePhotoTerms(images_, views, result_.mesh, {}, pairs, {}, energy, context_);
    }
    if (options_.max_gap_share > 0) {
      result_.mesh.vertex_quality = VertexQuality(result_.mesh, pairs, terms);
    }
    const FinishingOptions finishing{
        .border_cost = 0.5 * options_.max_gap_share * MeanLongerSide(views),
        .max_hole_edges = options_.max_hole_edges};
    const FinishingSummary summary =
        FinishSurface(pairs, terms, finishing, &result_.mesh, context_);
    result_.num_dropped_faces = summary.num_dropped_faces;
    result_.num_closed_holes = summary.num_closed_holes;
    result_.guard_seconds = stopwatch.Seconds();
  }

  FacePairs SelectJudges(const std::vector<PosedCamera>& views) {
    const std::vector<uint8_t> all_take_part(scene_.views.size(), 0);
    const auto judges =
        NeighborPairs(scene_, options_, kGuardNeighborFactor * options_.max_num_neighbors,
                      all_take_part, context_);
    PairSelectionOptions selection = MakePairSelectionOptions(options_, context_);
    selection.max_pairs_per_face = std::min(options_.max_pairs_per_face, kMaxGuardPairs);
    regions_ = GrowFaceRegions(result_.mesh, kFacesPerGuardRegion);
    return SelectOtherFacePairs(views, judges, result_.mesh, regions_, pairs_, selection, context_);
  }

  // Terms of the mesh that is left.
  PhotoTerms Guard(const std::vector<PosedCamera>& views, const FacePairs& pairs,
                   const PhotoEnergyOptions& energy) {
    RollbackSummary summary = RollBackWorseRegions(images_, views, regions_, pairs, input_,
                                                   Gain(pairs), energy, &result_.mesh, context_);
    result_.num_regions = static_cast<size_t>(regions_.count);
    result_.num_regions_restored = summary.num_regions_restored;
    result_.input_photo_error = summary.input_error;
    result_.output_photo_error = summary.output_error;
    return std::move(summary.terms);
  }

  // Of the refined mesh over the input, in the units of `pairs`.
  SmoothnessGain Gain(const FacePairs& pairs) const {
    Smoothness plate(result_.mesh, {options_.smoothness, options_.membrane, options_.laplacian});
    const std::vector<double> pixel_size = MeanPixelSizes(result_.mesh, pairs);
    SoftenAtCreases(pixel_size, &plate);
    const auto energies = [&](const TriangleMesh& mesh) {
      plate.SetGeometry(mesh.vertices, VertexDirections(mesh), pixel_size, context_);
      return plate.Energies();
    };
    const std::vector<double> after = energies(result_.mesh);
    TriangleMesh input;
    input.vertices = input_;
    input.faces = result_.mesh.faces;
    SmoothnessGain gain{energies(input)};
    for (size_t v = 0; v < after.size(); ++v) {
      gain.of_vertex[v] = pairs.per_face * (gain.of_vertex[v] - after[v]);
    }
    return gain;
  }

  // As the last step of the optimiser found the creases.
  void SoftenAtCreases(const std::vector<double>& pixel_size, Smoothness* plate) const {
    if (options_.flat_stiffness == 1 || options_.optimizer == RefinementOptimizer::kLbfgs) return;
    plate->SetGeometry(result_.mesh.vertices, VertexDirections(result_.mesh), pixel_size, context_);
    const CreaseWeights weights(result_.mesh, GrowFaceRegions(result_.mesh, kFacesPerRegion),
                                options_.flat_stiffness);
    plate->SetFactors(weights.Factors(plate->SquaredLaplacians(), plate->rings(), context_));
  }

  void Simplify(const RunContext& context) {
    const Stopwatch stopwatch;
    std::vector<double> tolerance =
        VertexPixelSizes(result_.mesh, MakeLevelViews(scene_, images_, 0), context_);
    for (double& t : tolerance) t *= options_.simplify_tolerance;
    // Of no use for fewer faces; the simplification needs memory, too.
    input_ = {};
    regions_ = {};
    pairs_ = {};
    result_.mesh = SimplifyWithinTolerance(result_.mesh, tolerance, {}, context).mesh;
    result_.simplify_seconds = stopwatch.Seconds();
  }

  void Color() {
    const Stopwatch stopwatch;
    images_.Trim(0);
    VertexColorOptions color_options;
    color_options.depth_tolerance = options_.depth_tolerance;
    result_.mesh.vertex_colors =
        ColorVertices(scene_, images_, result_.mesh, color_options, context_);
    result_.color_seconds = stopwatch.Seconds();
  }

  const Scene& scene_;
  const ImageStore& images_;
  const MeshRefinerOptions& options_;
  const RunContext& context_;
  const RefinementCheckpoints checkpoints_;
  std::vector<ViewPair> candidates_;
  // Where each vertex lies on the input surface.
  std::vector<Eigen::Vector3d> input_;
  FaceRegions regions_;  // of the present mesh
  FacePairs pairs_;      // of the present mesh
  RefinementResult result_;
};

}  // namespace

RefinementResult RefineMesh(const Scene& scene, const ImageStore& images, TriangleMesh mesh,
                            const MeshRefinerOptions& options, const RunContext& context,
                            const CheckpointFolder& checkpoints) {
  RequireValid(options);
  return MeshRefiner(scene, images, options, context, checkpoints).Run(std::move(mesh));
}

namespace {

// While the triangles of the input are adapted.
double AdaptationBytes(double num_input_faces, double num_faces) {
  // The input with rest positions, and again in work with links and origins; the sorted sides of
  // faces, by which these are linked; densities, twice; pairs and regions.
  constexpr double kBefore = (12 + 2 * 24 / 2.0) + (2 * 24 / 2.0 + 32 + 5) + 3 * 16 + 2 * 4 + 40;
  // The result with rest positions, the grid that finds crossings, edges to collapse.
  constexpr double kAfter = (12 + 2 * 24 / 2.0) + 40 + 24;
  return num_input_faces * kBefore + num_faces * kAfter;
}

// While a step at full resolution is tried, with photos of `num_pixels` held.
double StepBytes(double num_faces, double num_pixels, double largest, double num_maps,
                 int num_threads) {
  // Positions: of the mesh, before and after the step, of the input; directions, twice. Pixel size,
  // anchor, step, gradients and curvatures of both. Region and marks. Smoothness: rings of six and
  // three weights a neighbour.
  constexpr double kVertex = 6 * 24 + 7 * 8 + 7 + (8 + 6 * 4 * 4 + 16);
  // Corners, region, pairs with their sizes; error, mass and pixels of both.
  constexpr double kFace = 12 + 4 + (6 * 4 + 8) + 2 * 12 + 1;
  // Each thread: where a face is in its list, vertices projected; the faces of its view with their
  // sums, in work and waiting to be added.
  constexpr double kFaceInThread = 4 + 40 / 2.0, kFaceOfView = 8 + 36 + 40;
  // Photos in grey; depth maps of the views that are needed at once, face maps of half of these.
  constexpr double kPixel = 4, kMapPixel = 4 + 4 / 2.0;
  const double faces_of_view = std::min(num_faces, largest / kPixelsOfFace);
  return num_faces * (kVertex / 2 + kFace) +
         num_threads * (num_faces * kFaceInThread + faces_of_view * kFaceOfView) +
         num_pixels * kPixel + num_maps * largest * kMapPixel;
}

}  // namespace

CostEstimate EstimateRefinementCost(const Scene& scene, const ImageStore& images,
                                    size_t num_input_faces, const MeshRefinerOptions& options,
                                    const RunContext& context) {
  double pixels = 0;
  for (int v = 0; v < scene.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(v, 0);
    pixels += static_cast<double>(camera.width) * camera.height;
  }
  const auto largest = static_cast<double>(LargestImagePixels(images));
  const auto input_faces = static_cast<double>(num_input_faces);
  const double surface_pixels = pixels * EstimateSurfaceShare(scene).once;
  // Faces are halved while they are larger: they end at three quarters of that, in the mean.
  const double faces_by_area =
      options.max_face_area_px > 0 ? surface_pixels / (0.75 * options.max_face_area_px) : 0;
  const double faces_left =
      options.improve_mesh
          ? std::clamp(surface_pixels / kPixelsOfFace, kPartThatStays * input_faces, input_faces)
          : input_faces;
  const double faces = std::max(faces_left, faces_by_area);
  const double evaluations = options.max_num_iterations / 2.0 + 1.0;
  CostEstimate cost;
  cost.cpu_seconds = evaluations * (kLevelSum * pixels * kSecondsPerPixel +
                                    options.num_levels * input_faces * kSecondsPerFace) +
                     pixels * kSecondsPerPixelOnce;
  // Photos and maps share half of the budget.
  const double pixels_held =
      std::min(pixels, static_cast<double>(context.memory_budget_bytes) / 2 / 10);
  // Views are worked on in an order that needs few maps at once.
  constexpr int kMapsHeld = 4;
  const double num_maps = std::min(scene.num_views(), kMapsHeld + context.num_threads());
  // With the mesh that is simplified.
  constexpr double kSimplificationBytes = 355;
  const double simplification = options.simplify_tolerance > 0 ? kSimplificationBytes * faces : 0;
  cost.peak_bytes = static_cast<size_t>(
      std::max({AdaptationBytes(input_faces, faces), simplification,
                StepBytes(faces, pixels_held, largest, num_maps, context.num_threads())}));
  return cost;
}

namespace {

// Of the arrays of a step, those that are too small for the scratch file.
size_t SmallArrayBytes(size_t num_vertices) {
  struct Kind {
    size_t count, bytes_per_vertex;
  };
  constexpr std::array<Kind, 3> kKinds = {{{6, 24}, {14, 8}, {8, 1}}};
  size_t sum = 0;
  for (const auto& [count, bytes_per_vertex] : kKinds) {
    const size_t size = bytes_per_vertex * num_vertices;
    if (size < kMinScratchBlock) sum += count * size;
  }
  return sum;
}

}  // namespace

size_t LeastRefinementBytes(const ImageStore& images, size_t num_input_faces, size_t needed_bytes,
                            int num_threads) {
  // A thread holds photo, depth and faces of a view, and photo and depth of those that it is
  // compared with: about six. Larger blocks may lie in the scratch file themselves.
  constexpr size_t kPlanes = 3 + 2 * 6, kPlaneBytes = 4;
  const size_t of_thread =
      kPlanes * std::min(kPlaneBytes * LargestImagePixels(images), kMinScratchBlock);
  // Where less of the mesh is in memory, it comes and goes too often.
  constexpr size_t kLeastMesh = 96 << 20, kLeastShare = 8;
  return static_cast<size_t>(num_threads) * of_thread + SmallArrayBytes(num_input_faces / 2) +
         std::max(kLeastMesh, needed_bytes / kLeastShare);
}

size_t RefinementCheckpointBytes(size_t num_input_faces, const MeshRefinerOptions& options) {
  return RefinementCheckpoints::Bytes(num_input_faces, options.max_pairs_per_face);
}

}  // namespace lsmvs
