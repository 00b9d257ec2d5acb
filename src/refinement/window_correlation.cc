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

// out[x] = sum of in[x - radius .. x + radius]; `in` is readable that far on both sides.
void BoxRow(const float* HWY_RESTRICT in, int width, int radius, float* HWY_RESTRICT out) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < width; x += lanes) {
    auto sum = hn::LoadU(d, in + x - radius);
    for (int k = 1 - radius; k <= radius; ++k) sum = hn::Add(sum, hn::LoadU(d, in + x + k));
    hn::StoreU(sum, d, out + x);
  }
}

// out[x] = sum over the window's rows of plane `plane` around `row`.
void SumRows(RowRing* ring, int plane, int row, int radius, int width, float* HWY_RESTRICT out) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const float* rows[2 * kMaxRadius + 1];
  const int count = 2 * radius + 1;
  for (int k = 0; k < count; ++k) rows[k] = ring->Row(plane, row - radius + k);
  for (int x = 0; x < width; x += lanes) {
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
    for (int row = 0; row < tile_.height + 2 * radius_; ++row) {
      PushForward(row);
      if (row >= radius_) PushBackward(row - radius_);
      if (row >= 2 * radius_) Finish(row - 2 * radius_);
    }
  }

 private:
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

  // Row sums of the products that the windows' statistics need.
  void PushForward(int row) {
    if (row >= tile_.height) return forward_.Clear(row);
    const float* HWY_RESTRICT a = tile_.reference.data() + Start(row);
    const float* HWY_RESTRICT b = tile_.warped.data() + Start(row);
    const float* HWY_RESTRICT valid = tile_.valid.data() + Start(row);
    float* HWY_RESTRICT pa = Product(1);
    float* HWY_RESTRICT pb = Product(2);
    float* HWY_RESTRICT paa = Product(3);
    float* HWY_RESTRICT pbb = Product(4);
    float* HWY_RESTRICT pab = Product(5);
    std::copy(valid, valid + tile_.width, Product(0));
    for (int x = 0; x < tile_.width; ++x) {
      // Around mid grey, so that the squares keep their digits.
      const float va = (a[x] - 128.0f) * valid[x], vb = (b[x] - 128.0f) * valid[x];
      pa[x] = va;
      pb[x] = vb;
      paa[x] = va * va;
      pbb[x] = vb * vb;
      pab[x] = va * vb;
    }
    for (int plane = 0; plane < kNumForward; ++plane) {
      BoxRow(Product(plane), tile_.width, radius_, forward_.Row(plane, row));
    }
  }

  // Correlation of the windows of a row, and row sums of what their derivatives need.
  void PushBackward(int row) {
    if (row >= tile_.height) return backward_.Clear(row);
    for (int plane = 0; plane < kNumForward; ++plane) {
      SumRows(&forward_, plane, row, radius_, tile_.width, Sum(plane));
    }
    Score(row);
    for (int plane = 0; plane < kNumBackward; ++plane) {
      BoxRow(Product(plane), tile_.width, radius_, backward_.Row(plane, row));
    }
  }

  void Score(int row) {
    const float* HWY_RESTRICT n = Sum(0);
    const float* HWY_RESTRICT sa = Sum(1);
    const float* HWY_RESTRICT sb = Sum(2);
    const float* HWY_RESTRICT saa = Sum(3);
    const float* HWY_RESTRICT sbb = Sum(4);
    const float* HWY_RESTRICT sab = Sum(5);
    const float* HWY_RESTRICT weight = tile_.weight.data() + Start(row);
    const float* HWY_RESTRICT valid = tile_.valid.data() + Start(row);
    float* HWY_RESTRICT error = tile_.error.data() + Start(row);
    float* HWY_RESTRICT mass = tile_.mass.data() + Start(row);
    float* HWY_RESTRICT alpha = Product(0);
    float* HWY_RESTRICT beta = Product(1);
    float* HWY_RESTRICT gamma = Product(2);
    float* HWY_RESTRICT kappa = Product(3);
    const float min_valid = options_.min_valid_fraction * static_cast<float>(num_rows_ * num_rows_);
    const float noise = options_.noise_variance, scale = options_.robust_scale;
    for (int x = 0; x < tile_.width; ++x) {
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
      const float scaled = judged * inverse_n * robust * robust;
      const float inverse_var_b = 1.0f / var_b;
      mass[x] = judged;
      error[x] = judged * (1.0f - zncc) * robust;
      alpha[x] = scaled * inverse_norm;
      beta[x] = scaled * zncc * inverse_var_b;
      gamma[x] = alpha[x] * mean_a - beta[x] * mean_b;
      kappa[x] = scaled * inverse_var_b;
    }
  }

  void Finish(int row) {
    for (int plane = 0; plane < kNumBackward; ++plane) {
      SumRows(&backward_, plane, row, radius_, tile_.width, Sum(plane));
    }
    const float* HWY_RESTRICT a = tile_.reference.data() + Start(row);
    const float* HWY_RESTRICT b = tile_.warped.data() + Start(row);
    const float* HWY_RESTRICT valid = tile_.valid.data() + Start(row);
    const float* HWY_RESTRICT alpha = Sum(0);
    const float* HWY_RESTRICT beta = Sum(1);
    const float* HWY_RESTRICT gamma = Sum(2);
    const float* HWY_RESTRICT kappa = Sum(3);
    float* HWY_RESTRICT derivative = tile_.derivative.data() + Start(row);
    float* HWY_RESTRICT curvature = tile_.curvature.data() + Start(row);
    for (int x = 0; x < tile_.width; ++x) {
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

void CorrelateWindows(const CorrelationOptions& options, CorrelationScratch* scratch,
                      CorrelationTile* tile) {
  HWY_DYNAMIC_DISPATCH(Correlate)(options, scratch, tile);
}

}  // namespace lsmvs
#endif
