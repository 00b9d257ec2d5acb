#include "lsmvs/evaluation/texture_score.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "lsmvs/evaluation/mesh_renderer.h"
#include "lsmvs/evaluation/photos/box_filter.h"
#include "lsmvs/evaluation/photos/view_choice.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr int kWindowRadius = 3;
// Constants of SSIM, for values up to 255.
constexpr double kSsim1 = 0.01 * 255 * 0.01 * 255, kSsim2 = 0.03 * 255 * 0.03 * 255;
// Windows of less variance in both pictures [grey levels squared] have no texture to correlate.
constexpr double kLeastVariance = 9;

double Gray(const Eigen::Vector3d& color) {
  return color.dot(Eigen::Vector3d(0.299, 0.587, 0.114));
}

// Takes `margin` pixels off the border of what is not 0.
ByteImage Eroded(const ByteImage& mask, int margin) {
  ByteImage result = mask;
  for (int step = 0; step < margin; ++step) {
    const ByteImage before = result;
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        const bool at_rim = x == 0 || y == 0 || x == mask.width - 1 || y == mask.height - 1;
        if (at_rim || !before(x - 1, y) || !before(x + 1, y) || !before(x, y - 1) ||
            !before(x, y + 1)) {
          result(x, y) = 0;
        }
      }
    }
  }
  return result;
}

// A drawing and a photo of the same size with the pixels that are compared.
struct Pair {
  std::vector<Eigen::Vector3d> drawing, photo;  // per pixel
  ByteImage mask;
};

// Least squares fit of photo = gain * drawing + bias in one channel over the mask.
void FitChannel(const Pair& pair, int channel, double* gain, double* bias) {
  double n = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  for (size_t i = 0; i < pair.mask.size(); ++i) {
    if (!pair.mask.pixels[i]) continue;
    const double x = pair.drawing[i][channel], y = pair.photo[i][channel];
    n += 1;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const double variance = sum_xx - sum_x * sum_x / n;
  *gain = variance > 1e-9 * n ? (sum_xy - sum_x * sum_y / n) / variance : 1;
  *bias = (sum_y - *gain * sum_x) / n;
}

double Psnr(const Pair& pair) {
  double sum = 0, n = 0;
  for (size_t i = 0; i < pair.mask.size(); ++i) {
    if (!pair.mask.pixels[i]) continue;
    sum += (pair.drawing[i] - pair.photo[i]).squaredNorm();
    n += 3;
  }
  const double mse = std::max(sum / n, 1e-6);  // 108 dB: nothing to tell apart
  return 10 * std::log10(255 * 255 / mse);
}

// Means over windows that lie in the mask.
struct WindowMeans {
  GrayImage share, x, y, xx, yy, xy;
};

WindowMeans MeansOf(const Pair& pair) {
  const int width = pair.mask.width, height = pair.mask.height;
  WindowMeans means;
  GrayImage values(width, height), scratch;
  const auto mean_of = [&](const auto& value, GrayImage* mean) {
    for (size_t i = 0; i < values.size(); ++i) {
      values.pixels[i] = pair.mask.pixels[i] ? static_cast<float>(value(i)) : 0.0f;
    }
    BoxMean(values, kWindowRadius, &scratch, mean);
  };
  // About the middle of the range: sums of squares in single precision lose digits otherwise.
  const auto x = [&](size_t i) { return Gray(pair.drawing[i]) - 128; };
  const auto y = [&](size_t i) { return Gray(pair.photo[i]) - 128; };
  mean_of([](size_t) { return 1.0; }, &means.share);
  mean_of(x, &means.x);
  mean_of(y, &means.y);
  mean_of([&](size_t i) { return x(i) * x(i); }, &means.xx);
  mean_of([&](size_t i) { return y(i) * y(i); }, &means.yy);
  mean_of([&](size_t i) { return x(i) * y(i); }, &means.xy);
  return means;
}

void ScoreWindows(const Pair& pair, TextureViewScore* score) {
  const WindowMeans means = MeansOf(pair);
  double sum_ssim = 0, num_windows = 0, sum_ncc = 0, num_textured = 0;
  for (size_t i = 0; i < pair.mask.size(); ++i) {
    if (!pair.mask.pixels[i] || means.share.pixels[i] < 0.999f) continue;
    const double x = means.x.pixels[i], y = means.y.pixels[i];
    const double xx = std::max(0.0, means.xx.pixels[i] - x * x);
    const double yy = std::max(0.0, means.yy.pixels[i] - y * y);
    const double xy = means.xy.pixels[i] - x * y;
    const double level_x = x + 128, level_y = y + 128;
    sum_ssim += (2 * level_x * level_y + kSsim1) * (2 * xy + kSsim2) /
                ((level_x * level_x + level_y * level_y + kSsim1) * (xx + yy + kSsim2));
    ++num_windows;
    if (xx < kLeastVariance || yy < kLeastVariance) continue;
    sum_ncc += std::clamp(xy / std::sqrt(xx * yy), -1.0, 1.0);
    ++num_textured;
  }
  score->ssim = num_windows > 0 ? sum_ssim / num_windows : 0;
  score->one_minus_ncc = num_textured > 0 ? 1 - sum_ncc / num_textured : 0;
}

class Scorer {
 public:
  Scorer(const MeshTracer& tracer, const TriangleMesh& mesh, const TexturePages* texture,
         const Scene& scene, const ImageStore& images, const TextureScoreOptions& options,
         const RunContext& context)
      : tracer_(tracer),
        mesh_(mesh),
        texture_(texture),
        scene_(scene),
        images_(images),
        options_(options),
        context_(context) {}

  TextureViewScore Score(int view_idx) const {
    TextureViewScore score;
    score.name = scene_.views[static_cast<size_t>(view_idx)].name;
    Pair pair = MakePair(view_idx, &score.completeness);
    score.num_pixels = static_cast<size_t>(
        std::count(pair.mask.pixels.begin(), pair.mask.pixels.end(), uint8_t{1}));
    if (score.num_pixels == 0) return score;
    for (int k = 0; k < 3; ++k) {
      double& gain = score.gain[static_cast<size_t>(k)];
      double& bias = score.bias[static_cast<size_t>(k)];
      FitChannel(pair, k, &gain, &bias);
      for (Eigen::Vector3d& color : pair.drawing) {
        color[k] = std::clamp(gain * color[k] + bias, 0.0, 255.0);
      }
    }
    score.psnr = Psnr(pair);
    ScoreWindows(pair, &score);
    return score;
  }

 private:
  Pair MakePair(int view_idx, double* completeness) const {
    const PosedCamera viewpoint = {images_.Camera(view_idx, options_.level),
                                   scene_.views[static_cast<size_t>(view_idx)].cam_from_world};
    RenderOptions render;
    render.style = RenderStyle::kColor;
    render.antialiasing = options_.antialiasing;
    render.num_occlusion_rays = 0;
    RunContext quiet = context_;
    quiet.set_progress(nullptr);
    const ColorImage drawing = RenderMesh(mesh_, tracer_, viewpoint, render, quiet, texture_);
    const Raster<float> depth =
        TraceDepth(tracer_, viewpoint.camera, viewpoint.cam_from_world, quiet);
    const std::shared_ptr<const ColorImage> photo = images_.Colors(view_idx, options_.level);
    const std::shared_ptr<const ByteImage> used = images_.Mask(view_idx, options_.level);

    Pair pair;
    ByteImage seen(depth.width, depth.height, 0);
    double num_used = 0, num_seen = 0;
    for (size_t i = 0; i < depth.size(); ++i) {
      const bool is_used = !used || used->pixels[i] != 0;
      seen.pixels[i] = is_used && depth.pixels[i] > 0;
      num_used += is_used;
      num_seen += seen.pixels[i];
      pair.drawing.push_back(drawing.pixels[i].cast<double>());
      pair.photo.push_back(photo->pixels[i].cast<double>());
    }
    *completeness = num_used > 0 ? num_seen / num_used : 0;
    pair.mask = Eroded(seen, options_.margin);
    return pair;
  }

  const MeshTracer& tracer_;
  const TriangleMesh& mesh_;
  const TexturePages* const texture_;
  const Scene& scene_;
  const ImageStore& images_;
  const TextureScoreOptions& options_;
  const RunContext& context_;
};

void AddMeans(TextureScore* score) {
  for (const TextureViewScore& view : score->views) {
    if (view.num_pixels == 0) continue;
    ++score->num_scored_views;
    score->completeness += view.completeness;
    score->psnr += view.psnr;
    score->ssim += view.ssim;
    score->one_minus_ncc += view.one_minus_ncc;
  }
  const double n = std::max<double>(1, static_cast<double>(score->num_scored_views));
  for (double* sum : {&score->completeness, &score->psnr, &score->ssim, &score->one_minus_ncc}) {
    *sum /= n;
  }
}

}  // namespace

void TextureScoreOptions::Describe(OptionSet* options) {
  options->Add("TextureScore.level", &level, "Pyramid level of the photos: 0 full size, 1 half",
               {0, 8});
  options->Add("TextureScore.antialiasing", &antialiasing,
               "Rays a pixel of the drawing are the square of this", {1, 8});
  options->Add("TextureScore.margin", &margin,
               "Pixels at the mesh's silhouette that are not scored", {0, 100});
}

TextureScore MeasureTextureScore(const MeshTracer& tracer, const TriangleMesh& mesh,
                                 const TexturePages* texture, const Scene& scene,
                                 const ImageStore& images, const std::vector<int>& view_idxs,
                                 const TextureScoreOptions& options, const RunContext& context) {
  std::string error;
  if (!options.Check(&error)) throw UsageError(error);
  const std::vector<int> scored = NamedViewsOrAll(view_idxs, scene);
  const Scorer scorer(tracer, mesh, texture, scene, images, options, context);
  TextureScore score;
  for (const int view_idx : scored) {
    context.ThrowIfCancelled();
    score.views.push_back(scorer.Score(view_idx));
    context.Report(static_cast<double>(score.views.size()) / static_cast<double>(scored.size()));
  }
  AddMeans(&score);
  return score;
}

}  // namespace lsmvs
