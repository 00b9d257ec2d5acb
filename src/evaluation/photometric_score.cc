#include "lsmvs/evaluation/photometric_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lsmvs/evaluation/photos/box_filter.h"
#include "lsmvs/evaluation/photos/view_choice.h"
#include "lsmvs/geometry/posed_camera.h"
#include "lsmvs/image/sampling.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();

// For each view the views that share most sparse points with it, best first.
std::vector<std::vector<int>> MostShared(const Scene& scene, int count) {
  const size_t n = scene.views.size();
  std::vector<int> shared(n * n, 0);
  for (const SparsePoint& point : scene.points) {
    for (const int a : point.view_idxs) {
      for (const int b : point.view_idxs) ++shared[static_cast<size_t>(a) * n + b];
    }
  }
  std::vector<std::vector<int>> result(n);
  for (size_t i = 0; i < n; ++i) {
    std::vector<int> others(n);
    std::iota(others.begin(), others.end(), 0);
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    std::stable_sort(others.begin(), others.end(),
                     [&](int a, int b) { return shared[i * n + a] > shared[i * n + b]; });
    others.resize(std::min<size_t>(others.size(), static_cast<size_t>(count)));
    result[i] = std::move(others);
  }
  return result;
}

// One view at the level that is scored.
struct LevelView : PosedCamera {
  Raster<float> depth;
};

// Scratch of one thread: images that are made again and again.
struct Fields {
  GrayImage mask, own, warped, product, scratch;
  GrayImage share, mean_own, mean_warped, own_squared, warped_squared, cross;
};

// Warps the neighbour's photo into the view through the surface. mask = 1 where it sees the
// surface; own and warped are multiplied with it.
void Warp(const LevelView& view, const GrayImage& image, const LevelView& neighbor,
          const GrayImage& neighbor_image, double depth_tolerance, Fields* fields) {
  const int width = image.width, height = image.height;
  for (GrayImage* field : {&fields->mask, &fields->own, &fields->warped}) {
    *field = GrayImage(width, height, 0.0f);
  }
  const Rigid3 neighbor_from_view = neighbor.cam_from_world * view.cam_from_world.Inverse();
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const float depth = view.depth(column, row);
      if (depth <= 0) continue;
      const Eigen::Vector3d x = neighbor_from_view * (depth * view.camera.PixelRay(column, row));
      if (x.z() <= 0) continue;
      const Eigen::Vector2d p = neighbor.camera.Project(x);
      if (!(p.x() > 1 && p.y() > 1 && p.x() < neighbor.camera.width - 1 &&
            p.y() < neighbor.camera.height - 1)) {
        continue;
      }
      const float seen = neighbor.depth(static_cast<int>(p.x()), static_cast<int>(p.y()));
      if (!(std::abs(seen - x.z()) < depth_tolerance * x.z())) continue;
      fields->mask(column, row) = 1;
      fields->own(column, row) = image(column, row);
      fields->warped(column, row) = SampleBilinear(neighbor_image, p.x(), p.y()).value;
    }
  }
}

void MultiplyBoxed(const GrayImage& a, const GrayImage& b, int radius, Fields* fields,
                   GrayImage* mean) {
  fields->product = a;
  for (size_t i = 0; i < a.size(); ++i) fields->product.pixels[i] *= b.pixels[i];
  BoxMean(fields->product, radius, &fields->scratch, mean);
}

// ZNCC over the seen part of each window; raises `best` where it is larger (NaN: nothing yet).
void CorrelateInto(const PhotometricOptions& options, Fields* fields, GrayImage* best) {
  const int radius = options.window / 2;
  Fields& f = *fields;
  BoxMean(f.mask, radius, &f.scratch, &f.share);
  BoxMean(f.own, radius, &f.scratch, &f.mean_own);
  BoxMean(f.warped, radius, &f.scratch, &f.mean_warped);
  MultiplyBoxed(f.own, f.own, radius, fields, &f.own_squared);
  MultiplyBoxed(f.warped, f.warped, radius, fields, &f.warped_squared);
  MultiplyBoxed(f.own, f.warped, radius, fields, &f.cross);
  const double floor = options.min_variance * 4 / 9;  // below it noise would pass for correlation
  for (size_t i = 0; i < best->size(); ++i) {
    const double share = f.share.pixels[i];
    if (f.mask.pixels[i] == 0 || share <= options.min_window_share) continue;
    const double own = f.mean_own.pixels[i] / share, warped = f.mean_warped.pixels[i] / share;
    const double own_variance = f.own_squared.pixels[i] / share - own * own;
    if (own_variance <= options.min_variance) continue;
    const double warped_variance = f.warped_squared.pixels[i] / share - warped * warped;
    const double covariance = f.cross.pixels[i] / share - own * warped;
    const double zncc =
        covariance / std::sqrt(std::max(own_variance, floor) * std::max(warped_variance, floor));
    float& value = best->pixels[i];
    // A surface that a neighbour sees but that correlates negatively counts as wrong, not as worse
    // than wrong.
    value = std::max(std::isnan(value) ? 0.0f : value, static_cast<float>(zncc));
  }
}

// 1 where the window around the pixel has texture.
std::vector<uint8_t> Textured(const GrayImage& image, const PhotometricOptions& options,
                              Fields* fields) {
  const int radius = options.window / 2;
  BoxMean(image, radius, &fields->scratch, &fields->mean_own);
  MultiplyBoxed(image, image, radius, fields, &fields->own_squared);
  std::vector<uint8_t> textured(image.size());
  for (size_t i = 0; i < image.size(); ++i) {
    const double mean = fields->mean_own.pixels[i];
    textured[i] = fields->own_squared.pixels[i] - mean * mean > options.min_variance;
  }
  return textured;
}

// The photos and depth maps of a scene at the level that is scored.
class Scorer {
 public:
  Scorer(const MeshTracer& tracer, const Scene& scene, const ImageStore& images,
         const PhotometricOptions& options, const RunContext& context)
      : scene_(scene),
        images_(images),
        options_(options),
        neighbors_(MostShared(scene, options.num_neighbors)) {
    for (int i = 0; i < scene.num_views(); ++i) {
      const View& view = scene.views[i];
      views_.push_back({{images.Camera(i, options.level), view.cam_from_world}, {}});
      views_.back().depth = TraceDepth(tracer, views_.back().camera, view.cam_from_world, context);
    }
  }

  const std::vector<LevelView>& views() const { return views_; }

  // Best ZNCC a pixel, NaN where no neighbour sees the surface; `values` gets those of textured
  // pixels.
  GrayImage Score(int view_idx, PhotometricViewScore* score, std::vector<float>* values) const {
    const auto image = images_.Gray(view_idx, options_.level);
    const auto mask = images_.Mask(view_idx, options_.level);
    LSMVS_CHECK_GT(std::min(image->width, image->height), options_.window);
    Fields fields;
    GrayImage best(image->width, image->height, kUnseen);
    for (const int neighbor : neighbors_[view_idx]) {
      const auto neighbor_image = images_.Gray(neighbor, options_.level);
      Warp(views_[view_idx], *image, views_[neighbor], *neighbor_image, options_.depth_tolerance,
           &fields);
      CorrelateInto(options_, &fields, &best);
    }
    const std::vector<uint8_t> textured = Textured(*image, options_, &fields);
    score->name = scene_.views[view_idx].name;
    for (size_t i = 0; i < best.size(); ++i) {
      if (!textured[i] || (mask && mask->pixels[i] == 0)) continue;
      ++score->num_textured;
      if (std::isnan(best.pixels[i])) continue;
      ++score->num_covered;
      score->sum_zncc += best.pixels[i];
      score->sum_positive_zncc += std::max(best.pixels[i], 0.0f);
      values->push_back(best.pixels[i]);
    }
    return best;
  }

 private:
  const Scene& scene_;
  const ImageStore& images_;
  const PhotometricOptions& options_;
  std::vector<std::vector<int>> neighbors_;
  std::vector<LevelView> views_;
};

// Adds the correlation of one view to the vertices that it sees.
void AddToVertices(const TriangleMesh& mesh, const LevelView& view, const GrayImage& best,
                   double depth_tolerance, std::vector<float>* sums, std::vector<int>* counts) {
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d x = view.cam_from_world * mesh.vertices[v];
    if (!(x.z() > 0)) continue;
    const Eigen::Vector2d p = view.camera.Project(x);
    if (!view.camera.Contains(p)) continue;
    const int column = static_cast<int>(p.x()), row = static_cast<int>(p.y());
    if (!(std::abs(view.depth(column, row) - x.z()) < depth_tolerance * x.z())) continue;
    const float zncc = best(column, row);
    if (std::isnan(zncc)) continue;
    (*sums)[v] += zncc;
    ++(*counts)[v];
  }
}

double Ratio(double sum, size_t count) { return count == 0 ? 0 : sum / static_cast<double>(count); }

void Total(std::vector<std::vector<float>>* values, PhotometricScore* result) {
  size_t textured = 0, covered = 0;
  double sum = 0, positive = 0;
  std::vector<float> all;
  for (size_t k = 0; k < result->views.size(); ++k) {
    const PhotometricViewScore& view = result->views[k];
    textured += view.num_textured;
    covered += view.num_covered;
    sum += view.sum_zncc;
    positive += view.sum_positive_zncc;
    all.insert(all.end(), (*values)[k].begin(), (*values)[k].end());
    (*values)[k] = {};
  }
  result->coverage = Ratio(static_cast<double>(covered), textured);
  result->mean_zncc = Ratio(sum, covered);
  result->score = Ratio(positive, textured);
  if (all.empty()) return;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  result->median_zncc = *middle;
}

}  // namespace

void PhotometricOptions::Describe(OptionSet* options) {
  options->Add("Photometric.num_neighbors", &num_neighbors, "Photos warped into each view",
               {1, 100});
  options->Add("Photometric.level", &level, "0: full-size photos; 1: half; each is 4 times faster",
               {0, 8});
  options->Add("Photometric.window", &window, "Side of the correlation window in pixels, odd",
               {3, 63});
  options->Add("Photometric.depth_tolerance", &depth_tolerance,
               "Relative difference of depth above which a photo does not see the surface",
               {1e-6, 1.0});
  options->Add("Photometric.min_window_share", &min_window_share,
               "Share of a window that must be seen", {0.0, 1.0});
  options->Add("Photometric.min_variance", &min_variance,
               "Windows of less variance (squared grey levels) are not judged", {0.1, 1e4});
}

bool PhotometricOptions::Check(std::string* error) const {
  if (window % 2 == 0) {
    *error = fmt::format("Photometric.window = {} must be odd", window);
    return false;
  }
  return CheckOptions(*this, error);
}

double PhotometricViewScore::Coverage() const {
  return Ratio(static_cast<double>(num_covered), num_textured);
}
double PhotometricViewScore::MeanZncc() const { return Ratio(sum_zncc, num_covered); }
double PhotometricViewScore::Score() const { return Ratio(sum_positive_zncc, num_textured); }

PhotometricScore MeasurePhotometricScore(const MeshTracer& tracer, const TriangleMesh& mesh,
                                         const Scene& scene, const ImageStore& images,
                                         const std::vector<int>& view_idxs, bool with_vertices,
                                         const PhotometricOptions& options,
                                         const RunContext& context) {
  std::string error;
  if (!options.Check(&error)) throw UsageError(error);
  const std::vector<int> scored = NamedViewsOrAll(view_idxs, scene);
  const Scorer scorer(tracer, scene, images, options, context.Part(0, 0.3));
  PhotometricScore result;
  result.views.resize(scored.size());
  std::vector<std::vector<float>> values(scored.size());
  std::vector<GrayImage> best(scored.size());
  ParallelFor(context, scored.size(), 1, [&](size_t k) {
    GrayImage image = scorer.Score(scored[k], &result.views[k], &values[k]);
    if (with_vertices) best[k] = std::move(image);
  });
  Total(&values, &result);
  if (!with_vertices) return result;

  std::vector<int> counts(mesh.vertices.size(), 0);
  result.vertex_zncc.assign(mesh.vertices.size(), 0.0f);
  for (size_t k = 0; k < scored.size(); ++k) {
    AddToVertices(mesh, scorer.views()[scored[k]], best[k], options.depth_tolerance,
                  &result.vertex_zncc, &counts);
  }
  for (size_t v = 0; v < counts.size(); ++v) {
    result.vertex_zncc[v] =
        counts[v] == 0 ? kUnseen : result.vertex_zncc[v] / static_cast<float>(counts[v]);
  }
  return result;
}

}  // namespace lsmvs
