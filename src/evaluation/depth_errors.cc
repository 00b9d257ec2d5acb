#include "lsmvs/evaluation/depth_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/statistics.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

PinholeCamera Thinned(const PinholeCamera& camera, int step) {
  return camera.Resized(std::max(1, camera.width / step), std::max(1, camera.height / step));
}

// Adds the errors of one view; `relative` collects |z - z_true| / z_true.
DepthErrorHistogram CountErrors(const Raster<float>& depth, const Raster<float>& true_depth,
                                double sigma_per_depth, int num_bins,
                                std::vector<double>* relative) {
  DepthErrorHistogram histogram;
  histogram.bins.assign(num_bins, 0);
  for (size_t i = 0; i < depth.size(); ++i) {
    if (true_depth.pixels[i] <= 0) continue;
    if (depth.pixels[i] <= 0) {
      ++histogram.num_missing;
      continue;
    }
    const double true_z = true_depth.pixels[i];
    relative->push_back(std::abs(depth.pixels[i] - true_z) / true_z);
    const double bin = relative->back() / sigma_per_depth;
    if (bin < num_bins) {
      ++histogram.bins[static_cast<size_t>(bin)];
    } else {
      ++histogram.num_larger;
    }
  }
  return histogram;
}

void Accumulate(const DepthErrorHistogram& view, DepthErrorHistogram* all) {
  for (size_t b = 0; b < view.bins.size(); ++b) all->bins[b] += view.bins[b];
  all->num_larger += view.num_larger;
  all->num_missing += view.num_missing;
}

}  // namespace

void DepthErrorOptions::Describe(OptionSet* options) {
  options->Add("DepthErrors.num_bins", &num_bins, "Bins of the histogram, one sigma each",
               {1, 1000});
  options->Add("DepthErrors.sigma_px", &sigma_px, "Sigma, in pixels on the surface", {1e-6, 1e6});
  options->Add("DepthErrors.pixel_step", &pixel_step, "Every so many pixels are looked at",
               {1, 64});
}

size_t DepthErrorHistogram::Total() const {
  return std::accumulate(bins.begin(), bins.end(), num_larger + num_missing);
}

double DepthErrorHistogram::ShareBelow(int num_sigma) const {
  LSMVS_CHECK(num_sigma >= 0 && num_sigma <= static_cast<int>(bins.size()));
  if (Total() == 0) return 0;
  const size_t below = std::accumulate(bins.begin(), bins.begin() + num_sigma, size_t{0});
  return static_cast<double>(below) / static_cast<double>(Total());
}

DepthErrors MeasureDepthErrors(const MeshTracer& reconstruction, const MeshTracer& truth,
                               const std::vector<View>& views, const DepthErrorOptions& options,
                               const RunContext& context) {
  RequireValid(options);
  DepthErrors result;
  result.all.name = "all";
  result.all.bins.assign(options.num_bins, 0);
  std::vector<double> all_relative;
  for (const View& view : views) {
    const PinholeCamera camera = Thinned(view.camera, options.pixel_step);
    const Raster<float> depth = TraceDepth(reconstruction, camera, view.cam_from_world, context);
    const Raster<float> true_depth = TraceDepth(truth, camera, view.cam_from_world, context);
    std::vector<double> relative;
    DepthErrorHistogram histogram =
        CountErrors(depth, true_depth, options.sigma_px / view.camera.MeanFocalLength(),
                    options.num_bins, &relative);
    histogram.name = view.name;
    all_relative.insert(all_relative.end(), relative.begin(), relative.end());
    if (!relative.empty()) histogram.median_relative = Median(&relative);
    Accumulate(histogram, &result.all);
    result.views.push_back(std::move(histogram));
    context.Report(static_cast<double>(result.views.size()) / static_cast<double>(views.size()));
  }
  if (!all_relative.empty()) result.all.median_relative = Median(&all_relative);
  return result;
}

}  // namespace lsmvs
