#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct DepthErrorOptions {
  // Bins of the histogram, each one sigma wide; larger errors are counted together.
  int num_bins = 10;
  // The standard deviation sigma of the truth, in pixels: at depth z one pixel covers z / focal
  // length.
  double sigma_px = 1.0;
  // Pixels are sampled every so many columns and rows.
  int pixel_step = 2;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Pixels of one view (or of all) that see the truth, by the error of their depth.
struct DepthErrorHistogram {
  std::string name;            // of the view
  std::vector<size_t> bins;    // [i]: error in [i, i + 1) sigma
  size_t num_larger = 0;       // beyond the last bin
  size_t num_missing = 0;      // the reconstruction has no depth there
  double median_relative = 0;  // |z - z_true| / z_true where both are known

  size_t Total() const;
  // Share of the pixels with an error below `num_sigma` (a whole number) sigma.
  double ShareBelow(int num_sigma) const;
};

struct DepthErrors {
  std::vector<DepthErrorHistogram> views;
  DepthErrorHistogram all;
};

// The histograms of Strecha et al., "On benchmarking camera calibration and multi-view stereo for
// high resolution imagery", CVPR 2008: both surfaces are rendered into every view; the errors of
// the depth are counted in units of the truth's standard deviation. There sigma comes from the
// laser scanner; here it is `sigma_px` pixels on the surface. Pixels that the reconstruction does
// not fill count as missing, those that the truth does not fill not at all. Deterministic. O(pixels
// / pixel_step^2 * log F).
DepthErrors MeasureDepthErrors(const MeshTracer& reconstruction, const MeshTracer& truth,
                               const std::vector<View>& views, const DepthErrorOptions& options,
                               const RunContext& context);

}  // namespace lsmvs
