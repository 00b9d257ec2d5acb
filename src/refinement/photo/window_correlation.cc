#include "lsmvs/refinement/photo/window_correlation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/refinement/photo/window_correlation.cc"
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
    // Room for whole vectors: what lies behind the span has no weight.
    const hn::ScalableTag<float> d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    float* const weight = Product(4);
    float* const valid = Product(5);
    const size_t first = Start(row) + static_cast<size_t>(span.begin);
    const size_t last = Start(row) + static_cast<size_t>(span.end);
    std::copy(&tile_.weight[first], &tile_.weight[last - 1] + 1, weight + span.begin);
    std::copy(&tile_.valid[first], &tile_.valid[last - 1] + 1, valid + span.begin);
    std::fill(weight + span.end, weight + span.end + lanes, 0.0f);
    for (int x = span.begin; x < span.end; x += lanes) ScoreLanes<kDerivatives>(x);
    std::copy(weight + span.begin, weight + span.end, mass + span.begin);
    std::copy(valid + span.begin, valid + span.end, error + span.begin);
    // As the products beyond the ends of a row, which no later row may find.
    std::fill(weight + tile_.width, weight + tile_.width + lanes, 0.0f);
    std::fill(valid + tile_.width, valid + tile_.width + lanes, 0.0f);
  }

  // Of a vector of windows from column x: sums -> masses and errors, in place of weights and valid
  // pixels, and what the derivatives need.
  template <bool kDerivatives>
  void ScoreLanes(int x) {
    const hn::ScalableTag<float> d;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto noise = hn::Set(d, options_.noise_variance);
    const auto texture_noise = hn::Set(d, 4.0f * options_.noise_variance);
    const auto scale = hn::Set(d, options_.robust_scale);
    const auto min_valid =
        hn::Set(d, options_.min_valid_fraction * static_cast<float>(num_rows_ * num_rows_));
    const auto sum = [&](int plane) { return hn::LoadU(d, Sum(plane) + x); };
    const auto n = sum(0), inverse_n = hn::Div(one, hn::Max(n, one));
    const auto mean_a = hn::Mul(sum(1), inverse_n), mean_b = hn::Mul(sum(2), inverse_n);
    const auto signal_a =
        hn::Max(hn::Sub(hn::Mul(sum(3), inverse_n), hn::Mul(mean_a, mean_a)), zero);
    const auto signal_b =
        hn::Max(hn::Sub(hn::Mul(sum(4), inverse_n), hn::Mul(mean_b, mean_b)), zero);
    const auto var_a = hn::Add(signal_a, noise), var_b = hn::Add(signal_b, noise);
    const auto covariance = hn::Sub(hn::Mul(sum(5), inverse_n), hn::Mul(mean_a, mean_b));
    const auto inverse_norm = hn::Div(one, hn::Sqrt(hn::Mul(var_a, var_b)));
    const auto zncc = hn::Mul(covariance, inverse_norm), difference = hn::Sub(one, zncc);
    const auto texture =
        hn::Div(signal_a, hn::Add(hn::Add(signal_a, texture_noise), hn::Set(d, 1e-6f)));
    float* const weight = Product(4) + x;
    float* const valid = Product(5) + x;
    const auto judged = hn::IfThenElseZero(
        hn::Ge(n, min_valid), hn::Mul(hn::Mul(hn::LoadU(d, weight), hn::LoadU(d, valid)), texture));
    const auto counts = hn::Gt(judged, zero);
    const auto robust = hn::Div(scale, hn::Add(difference, scale));
    hn::StoreU(hn::IfThenElseZero(counts, judged), d, weight);
    hn::StoreU(hn::IfThenElseZero(counts, hn::Mul(hn::Mul(judged, difference), robust)), d, valid);
    if (!kDerivatives) return;
    const auto scaled = hn::Mul(hn::Mul(hn::Mul(judged, inverse_n), robust), robust);
    const auto inverse_var_b = hn::Div(one, var_b);
    const auto alpha = hn::Mul(scaled, inverse_norm);
    const auto beta = hn::Mul(hn::Mul(scaled, zncc), inverse_var_b);
    const auto gamma = hn::Sub(hn::Mul(alpha, mean_a), hn::Mul(beta, mean_b));
    const auto kappa = hn::Mul(scaled, inverse_var_b);
    hn::StoreU(hn::IfThenElseZero(counts, alpha), d, Product(0) + x);
    hn::StoreU(hn::IfThenElseZero(counts, beta), d, Product(1) + x);
    hn::StoreU(hn::IfThenElseZero(counts, gamma), d, Product(2) + x);
    hn::StoreU(hn::IfThenElseZero(counts, kappa), d, Product(3) + x);
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
