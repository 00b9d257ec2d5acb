#include "lsmvs/refinement/mesh_refiner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "lsmvs/refinement/level_optimizer.h"
#include "lsmvs/refinement/vertex_colors.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr int kMinLevelSize = 64;
constexpr int kFacesPerRegion = 256;
// Relative cost of the levels for progress: each has about a quarter of the pixels of the next.
constexpr double kLevelCostRatio = 3.0;

// Measured on scenes of 11 to 24 photos.
constexpr double kSecondsPerPixel = 6e-8, kSecondsPerFaceAndView = 1.5e-7;
constexpr double kSecondsPerPixelOnce = 2e-7;  // decoding, colours
constexpr double kLevelSum = 1.33;             // pixels of all levels, relative to the finest
constexpr double kPixelsPerFace = 60, kMapBytesPerPixel = 8, kBytesPerFace = 350,
                 kBytesPerPixelInWork = 8;

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<uint8_t> HeldOut(int num_views, int every) {
  std::vector<uint8_t> held_out(static_cast<size_t>(num_views), 0);
  for (int v = every; every > 0 && v <= num_views; v += every) {
    held_out[static_cast<size_t>(v - 1)] = 1;
  }
  return held_out;
}

// Ordered pairs of neighbours, sorted by reference view; only such with a held-out view if
// `with_held_out`, else only such without.
std::vector<ViewPair> CandidatePairs(const Scene& scene, const MeshRefinerOptions& options,
                                     bool with_held_out) {
  ViewSelectionOptions selection;
  selection.max_num_neighbors = options.max_num_neighbors;
  selection.min_triangulation_angle_deg = options.min_triangulation_angle_deg / 2;
  selection.max_triangulation_angle_deg =
      std::max(options.max_triangulation_angle_deg, selection.min_triangulation_angle_deg);
  const auto neighbors = SelectNeighbors(scene, selection);
  const auto held_out = HeldOut(scene.num_views(), options.hold_out_every);
  std::vector<ViewPair> pairs;
  for (int i = 0; i < scene.num_views(); ++i) {
    for (const Neighbor& neighbor : neighbors[static_cast<size_t>(i)]) {
      const bool is_held_out =
          held_out[static_cast<size_t>(i)] || held_out[static_cast<size_t>(neighbor.view_idx)];
      if (is_held_out == with_held_out) pairs.push_back({i, neighbor.view_idx});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const ViewPair& a, const ViewPair& b) {
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
  return pairs;
}

PairSelectionOptions MakePairSelectionOptions(const MeshRefinerOptions& options) {
  PairSelectionOptions result;
  result.max_pairs_per_face = options.max_pairs_per_face;
  result.min_angle_deg = options.min_triangulation_angle_deg;
  result.max_angle_deg = options.max_triangulation_angle_deg;
  result.depth_tolerance = options.depth_tolerance;
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

}  // namespace

RefinementResult RefineMesh(const Scene& scene, const ImageStore& images, const TriangleMesh& mesh,
                            const MeshRefinerOptions& options, const RunContext& context) {
  std::string error;
  LSMVS_CHECK(options.Check(&error));
  RefinementResult result;
  result.mesh = mesh;
  const std::vector<ViewPair> candidates = CandidatePairs(scene, options, false);
  result.num_pairs = static_cast<int>(candidates.size());
  const std::vector<int> levels = Levels(images, options);
  double done = 0, all = 0;
  for (size_t k = 0; k < levels.size(); ++k) all += std::pow(kLevelCostRatio, k);
  for (size_t k = 0; k < levels.size(); ++k) {
    const double start = Seconds();
    const auto views = MakeLevelViews(scene, images, levels[k]);
    const FaceRegions regions = GrowFaceRegions(result.mesh, kFacesPerRegion);
    const FacePairs pairs = SelectFacePairs(views, candidates, result.mesh, regions,
                                            MakePairSelectionOptions(options), context);
    const double cost = std::pow(kLevelCostRatio, k);
    result.levels.push_back(OptimizeLevel(images, views, regions, pairs, options, levels[k],
                                          &result.mesh,
                                          context.Part(done / all, (done + cost) / all)));
    result.levels.back().seconds = Seconds() - start;
    done += cost;
  }
  if (options.color_vertices) {
    const double start = Seconds();
    VertexColorOptions color_options;
    color_options.depth_tolerance = options.depth_tolerance;
    result.mesh.vertex_colors = ColorVertices(scene, images, result.mesh, color_options, context);
    result.color_seconds = Seconds() - start;
  }
  return result;
}

CostEstimate EstimateRefinementCost(const Scene& scene, const ImageStore& images,
                                    size_t num_input_faces, const MeshRefinerOptions& options,
                                    const RunContext& context) {
  double pixels = 0, largest = 0;
  for (int v = 0; v < scene.num_views(); ++v) {
    const PinholeCamera camera = images.Camera(v, 0);
    const double size = static_cast<double>(camera.width) * camera.height;
    pixels += size;
    largest = std::max(largest, size);
  }
  const double faces = std::max(static_cast<double>(num_input_faces), pixels / kPixelsPerFace);
  const double evaluations = kLevelSum * (options.max_num_iterations / 2.0 + 1.0);
  CostEstimate cost;
  cost.cpu_seconds = evaluations * (pixels * kSecondsPerPixel +
                                    faces * scene.num_views() * kSecondsPerFaceAndView) +
                     pixels * kSecondsPerPixelOnce;
  const double maps =
      std::min(kMapBytesPerPixel * pixels, static_cast<double>(context.memory_budget_bytes) / 4);
  cost.peak_bytes = static_cast<size_t>(maps + kBytesPerFace * faces +
                                        context.num_threads() * kBytesPerPixelInWork * largest);
  return cost;
}

}  // namespace lsmvs
