#include "lsmvs/refinement/window_correlation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/refinement/window_correlation.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lsmvs {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kNumForward = 6;   // n, a, b, aa, bb, ab
constexpr int kNumBackward = 4;  // alpha, beta, gamma, kappa
// Rows are stored with room for the window and for whole vectors on both sides.
constexpr int kPadding = 64;
constexpr int kMaxRadius = 16;

// The last rows of several planes; rows before the first are zero.
class RowRing {
 public:
  RowRing(float* memory, int num_planes, int num_rows, int stride)
      : memory_(memory), num_planes_(num_planes), num_rows_(num_rows), stride_(stride) {}
  // Starts at column 0; padded on both sides. `row` >= -num_rows.
  float* Row(int plane, int row) {
    const int slot = ((row + num_rows_) % num_rows_) * num_planes_ + plane;
    return memory_ + static_cast<ptrdiff_t>(slot) * stride_ + kPadding;
  }
  void Clear(int row) {
    float* first = Row(0, row) - kPadding;
    std::fill(first, first + static_cast<ptrdiff_t>(num_planes_) * stride_, 0.0f);
  }

 private:
  float* memory_;
  int num_planes_, num_rows_, stride_;
};

// out[x] = sum of in[x - radius .. x + radius]; `in` is readable that far on both sides. Whole
// vectors are written: up to a vector beyond the span's end.
void BoxRow(const float* HWY_RESTRICT in, const ColumnSpan& span, int radius,
            float* HWY_RESTRICT out) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = span.begin; x < span.end; x += lanes) {
    auto sum = hn::LoadU(d, in + x - radius);
    for (int k = 1 - radius; k <= radius; ++k) sum = hn::Add(sum, hn::LoadU(d, in + x + k));
    hn::StoreU(sum, d, out + x);
  }
}

// out[x] = sum over the window's rows of plane `plane` around `row`.
void SumRows(RowRing* ring, int plane, int row, int radius, const ColumnSpan& span,
             float* HWY_RESTRICT out) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const float* rows[2 * kMaxRadius + 1];
  const int count = 2 * radius + 1;
  for (int k = 0; k < count; ++k) rows[k] = ring->Row(plane, row - radius + k);
  for (int x = span.begin; x < span.end; x += lanes) {
    auto sum = hn::LoadU(d, rows[0] + x);
    for (int k = 1; k < count; ++k) sum = hn::Add(sum, hn::LoadU(d, rows[k] + x));
    hn::StoreU(sum, d, out + x);
  }
}

class Correlator {
 public:
  Correlator(const CorrelationOptions& options, CorrelationScratch* scratch, CorrelationTile* tile)
      : options_(options),
        tile_(*tile),
        radius_(options.radius),
        num_rows_(2 * options.radius + 1),
        stride_(tile->width + 2 * kPadding),
        forward_(Take(scratch, 0), kNumForward, num_rows_, stride_),
        backward_(Take(scratch, kNumForward * num_rows_), kNumBackward, num_rows_, stride_),
        products_(Take(scratch, (kNumForward + kNumBackward) * num_rows_)),
        sums_(products_ + static_cast<ptrdiff_t>(kNumForward) * stride_) {}

  void Run() {
    if (!options_.derivatives) return RunForward();
    for (int row = 0; row < tile_.height + 2 * radius_; ++row) {
      PushForward(row);
      if (row >= radius_) PushBackward(row - radius_);
      if (row >= 2 * radius_) Finish(row - 2 * radius_);
    }
  }

 private:
  // Errors alone.
  void RunForward() {
    for (int row = 0; row < tile_.height + radius_; ++row) {
      PushForward(row);
      if (row >= radius_) Score<false>(row - radius_);
    }
  }

  float* Take(CorrelationScratch* scratch, int first_row) {
    const int total = (kNumForward + kNumBackward) * (num_rows_ + 1) + kNumForward;
    const size_t size = static_cast<size_t>(total) * static_cast<size_t>(stride_);
    if (scratch->rows.size() < size) scratch->rows.resize(size);
    if (first_row == 0) std::fill(scratch->rows.begin(), scratch->rows.end(), 0.0f);
    return scratch->rows.data() + static_cast<ptrdiff_t>(first_row) * stride_;
  }
  float* Product(int plane) {
    return products_ + static_cast<ptrdiff_t>(plane) * stride_ + kPadding;
  }
  float* Sum(int plane) { return sums_ + static_cast<ptrdiff_t>(plane) * stride_ + kPadding; }
  size_t Start(int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(tile_.width);
  }

  const ColumnSpan& Judged(int row) const { return tile_.judged[static_cast<size_t>(row)]; }
  const ColumnSpan& Reached(int row) const { return tile_.reached[static_cast<size_t>(row)]; }

  // Row sums of the products that the windows' statistics need.
  void PushForward(int row) {
    if (row >= tile_.height) return forward_.Clear(row);
    const ColumnSpan span = Reached(row);
    if (span.Empty()) return;  // no window needs them
    const float* HWY_RESTRICT a = tile_.reference.data() + Start(row);
    const float* HWY_RESTRICT b = tile_.warped.data() + Start(row);
    const float* HWY_RESTRICT valid = tile_.valid.data() + Start(row);
    float* HWY_RESTRICT pn = Product(0);
    float* HWY_RESTRICT pa = Product(1);
    float* HWY_RESTRICT pb = Product(2);
    float* HWY_RESTRICT paa = Product(3);
    float* HWY_RESTRICT pbb = Product(4);
    float* HWY_RESTRICT pab = Product(5);
    for (int x = span.begin; x < span.end; ++x) {
      // Around mid grey, so that the squares keep their digits.
      const float va = (a[x] - 128.0f) * valid[x], vb = (b[x] - 128.0f) * valid[x];
      pn[x] = valid[x];
      pa[x] = va;
      pb[x] = vb;
      paa[x] = va * va;
      pbb[x] = vb * vb;
      pab[x] = va * vb;
    }
    // Windows are judged a radius further inside, but for where the tile cuts them.
    const ColumnSpan judged = {span.begin > 0 ? span.begin + radius_ : 0,
                               span.end < tile_.width ? span.end - radius_ : tile_.width};
    for (int plane = 0; plane < kNumForward; ++plane) {
      BoxRow(Product(plane), judged, radius_, forward_.Row(plane, row));
    }
  }

  // Correlation of the windows of a row, and row sums of what their derivatives need.
  void PushBackward(int row) {
    backward_.Clear(row);
    if (row >= tile_.height) return;
    for (int plane = 0; plane < kNumBackward; ++plane) {
      std::fill(Product(plane), Product(plane) + tile_.width, 0.0f);
    }
    Score<true>(row);
    const ColumnSpan& judged = Judged(row);
    if (judged.Empty()) return;
    const ColumnSpan near = {std::max(0, judged.begin - radius_),
                             std::min(tile_.width, judged.end + radius_)};
    for (int plane = 0; plane < kNumBackward; ++plane) {
      BoxRow(Product(plane), near, radius_, backward_.Row(plane, row));
    }
  }

  // With kDerivatives also what the derivatives need, in the products.
  template <bool kDerivatives>
  void Score(int row) {
    const ColumnSpan span = Judged(row);
    float* HWY_RESTRICT error = tile_.error.data() + Start(row);
    float* HWY_RESTRICT mass = tile_.mass.data() + Start(row);
    std::fill(error, error + tile_.width, 0.0f);
    std::fill(mass, mass + tile_.width, 0.0f);
    if (span.Empty()) return;
    for (int plane = 0; plane < kNumForward; ++plane) {
      SumRows(&forward_, plane, row, radius_, span, Sum(plane));
    }
    const float* HWY_RESTRICT n = Sum(0);
    const float* HWY_RESTRICT sa = Sum(1);
    const float* HWY_RESTRICT sb = Sum(2);
    const float* HWY_RESTRICT saa = Sum(3);
    const float* HWY_RESTRICT sbb = Sum(4);
    const float* HWY_RESTRICT sab = Sum(5);
    const float* HWY_RESTRICT weight = tile_.weight.data() + Start(row);
    const float* HWY_RESTRICT valid = tile_.valid.data() + Start(row);
    float* HWY_RESTRICT alpha = Product(0);
    float* HWY_RESTRICT beta = Product(1);
    float* HWY_RESTRICT gamma = Product(2);
    float* HWY_RESTRICT kappa = Product(3);
    const float min_valid = options_.min_valid_fraction * static_cast<float>(num_rows_ * num_rows_);
    const float noise = options_.noise_variance, scale = options_.robust_scale;
    for (int x = span.begin; x < span.end; ++x) {
      const float inverse_n = 1.0f / std::max(n[x], 1.0f);
      const float mean_a = sa[x] * inverse_n, mean_b = sb[x] * inverse_n;
      const float signal_a = std::max(saa[x] * inverse_n - mean_a * mean_a, 0.0f);
      const float var_a = signal_a + noise;
      const float var_b = std::max(sbb[x] * inverse_n - mean_b * mean_b, 0.0f) + noise;
      const float covariance = sab[x] * inverse_n - mean_a * mean_b;
      const float inverse_norm = 1.0f / std::sqrt(var_a * var_b);
      const float zncc = covariance * inverse_norm;
      const float texture = signal_a / (signal_a + 4.0f * noise + 1e-6f);
      const float judged = n[x] >= min_valid ? weight[x] * valid[x] * texture : 0.0f;
      const float robust = scale / (1.0f - zncc + scale);
      mass[x] = judged;
      error[x] = judged * (1.0f - zncc) * robust;
      if (!kDerivatives) continue;
      const float scaled = judged * inverse_n * robust * robust;
      const float inverse_var_b = 1.0f / var_b;
      alpha[x] = scaled * inverse_norm;
      beta[x] = scaled * zncc * inverse_var_b;
      gamma[x] = alpha[x] * mean_a - beta[x] * mean_b;
      kappa[x] = scaled * inverse_var_b;
    }
  }

  void Finish(int row) {
    const ColumnSpan span = Reached(row);
    float* HWY_RESTRICT derivative = tile_.derivative.data() + Start(row);
    float* HWY_RESTRICT curvature = tile_.curvature.data() + Start(row);
    std::fill(derivative, derivative + tile_.width, 0.0f);
    std::fill(curvature, curvature + tile_.width, 0.0f);
    if (span.Empty()) return;
    for (int plane = 0; plane < kNumBackward; ++plane) {
      SumRows(&backward_, plane, row, radius_, span, Sum(plane));
    }
    const float* HWY_RESTRICT a = tile_.reference.data() + Start(row);
    const float* HWY_RESTRICT b = tile_.warped.data() + Start(row);
    const float* HWY_RESTRICT valid = tile_.valid.data() + Start(row);
    const float* HWY_RESTRICT alpha = Sum(0);
    const float* HWY_RESTRICT beta = Sum(1);
    const float* HWY_RESTRICT gamma = Sum(2);
    const float* HWY_RESTRICT kappa = Sum(3);
    for (int x = span.begin; x < span.end; ++x) {
      const float slope = (a[x] - 128.0f) * alpha[x] - (b[x] - 128.0f) * beta[x] - gamma[x];
      derivative[x] = -valid[x] * slope;
      curvature[x] = valid[x] * kappa[x];
    }
  }

  const CorrelationOptions& options_;
  CorrelationTile& tile_;
  int radius_, num_rows_, stride_;
  RowRing forward_, backward_;
  float* products_;
  float* sums_;
};

void Correlate(const CorrelationOptions& options, CorrelationScratch* scratch,
               CorrelationTile* tile) {
  Correlator(options, scratch, tile).Run();
}

}  // namespace HWY_NAMESPACE
}  // namespace lsmvs
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lsmvs {

HWY_EXPORT(Correlate);

void CorrelationTile::Resize(int tile_width, int tile_height) {
  width = tile_width;
  height = tile_height;
  const size_t size = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (auto* plane :
       {&reference, &warped, &valid, &weight, &error, &mass, &derivative, &curvature}) {
    if (plane->size() < size) plane->resize(size);
  }
}

void CorrelationTile::FindSpans(int radius) {
  const size_t num_rows = static_cast<size_t>(height);
  judged.assign(num_rows, {});
  reached.assign(num_rows, {});
  for (int row = 0; row < height; ++row) {
    const float* weights = weight.data() + static_cast<size_t>(row) * static_cast<size_t>(width);
    ColumnSpan& span = judged[static_cast<size_t>(row)];
    while (span.begin < width && weights[span.begin] == 0) ++span.begin;
    if (span.begin == width) continue;
    span.end = width;
    while (weights[span.end - 1] == 0) --span.end;
    const ColumnSpan near = {std::max(0, span.begin - radius), std::min(width, span.end + radius)};
    const int last = std::min(height - 1, row + radius);
    for (int r = std::max(0, row - radius); r <= last; ++r) {
      ColumnSpan& around = reached[static_cast<size_t>(r)];
      around = around.Empty()
                   ? near
                   : ColumnSpan{std::min(around.begin, near.begin), std::max(around.end, near.end)};
    }
  }
}

void CorrelateWindows(const CorrelationOptions& options, CorrelationScratch* scratch,
                      CorrelationTile* tile) {
  HWY_DYNAMIC_DISPATCH(Correlate)(options, scratch, tile);
}

}  // namespace lsmvs
#endif
