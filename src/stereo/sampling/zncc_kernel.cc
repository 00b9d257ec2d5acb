#include "lsmvs/stereo/sampling/zncc_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/stereo/sampling/zncc_kernel.cc"
#include <hwy/foreach_target.h>
// clang-format off
#include <hwy/highway.h>
// clang-format on
#include "lsmvs/stereo/sampling/packed_sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lsmvs {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, kPacketSize>;
using DI = hn::RebindToSigned<DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;
constexpr DF df;
constexpr DI di;

// Operations a vector of samples: 8 for the warp, 11 for the cell, its index and the weights within
// it, 10 to unpack its four pixels, 6 to interpolate, 4 for the sums: about 40, and one 32-bit load
// a lane, gathered: the floor. With two 512-bit ports and two loads a cycle that is 20 cycles for
// 16 samples, 0.45 ns per sample at 2.8 GHz, if all overlaps; measured 0.97 ns (stereo_bench in
// tests/bench, on a busy machine). A sample of four separately gathered floats takes 1.3 ns.

// A window that is stretched or tilted more than this is not matched. Together they keep every
// sample of a window whose corners lie inside the image within kPadding of it.
constexpr float kMaxTilt = 0.2f;      // relative change of depth from the centre to a corner
constexpr float kMaxStretch = 24.0f;  // pixels from the centre to a corner

// x(d) = center + (linear d) * (1 - tilt + tilt^2), tilt = tilt_u d_u + tilt_v d_v.
struct Warp {
  F x, y;            // centre
  F xu, xv, yu, yv;  // linear part
  F tilt_u, tilt_v;
  hn::Mask<DF> valid;
};

HWY_INLINE F Expand(F tilt) {
  return hn::NegMulAdd(tilt, hn::Sub(hn::Set(df, 1.0f), tilt), hn::Set(df, 1.0f));
}

HWY_INLINE void CheckCorner(const SourceView& source, float du_px, float dv_px, Warp* warp) {
  const F u = hn::Set(df, du_px), v = hn::Set(df, dv_px);
  const F tilt = hn::MulAdd(warp->tilt_v, v, hn::Mul(warp->tilt_u, u));
  const F r = Expand(tilt);
  const F dx = hn::Mul(r, hn::MulAdd(warp->xv, v, hn::Mul(warp->xu, u)));
  const F dy = hn::Mul(r, hn::MulAdd(warp->yv, v, hn::Mul(warp->yu, u)));
  const F x = hn::Add(warp->x, dx), y = hn::Add(warp->y, dy);
  const F zero = hn::Zero(df);
  const auto inside_x =
      hn::And(hn::Ge(x, zero), hn::Le(x, hn::Set(df, static_cast<float>(source.image->width - 1))));
  const auto inside_y = hn::And(
      hn::Ge(y, zero), hn::Le(y, hn::Set(df, static_cast<float>(source.image->height - 1))));
  const auto mild = hn::And(hn::Le(hn::Abs(tilt), hn::Set(df, kMaxTilt)),
                            hn::Le(hn::Max(hn::Abs(dx), hn::Abs(dy)), hn::Set(df, kMaxStretch)));
  warp->valid = hn::And(warp->valid, hn::And(mild, hn::And(inside_x, inside_y)));
}

HWY_INLINE Warp MakeWarp(const PatchPacket& patch, const WindowShape& window,
                         const PlanePacket& planes, const SourceView& source, size_t lane) {
  const F u = hn::Load(df, patch.u + lane), v = hn::Load(df, patch.v + lane);
  const F q = hn::Load(df, planes.q + lane);
  const F qx = hn::Load(df, planes.qx + lane), qy = hn::Load(df, planes.qy + lane);
  const auto coefficient = [](float value) HWY_ATTR { return hn::Set(df, value); };
  const float *m = source.m, *e = source.e;
  F center[3], along_u[3], along_v[3];
  for (int i = 0; i < 3; ++i) {
    const F ei = coefficient(e[i]);
    const F at_infinity =
        hn::MulAdd(coefficient(m[3 * i]), u,
                   hn::MulAdd(coefficient(m[3 * i + 1]), v, coefficient(m[3 * i + 2])));
    center[i] = hn::MulAdd(ei, q, at_infinity);
    along_u[i] = hn::MulAdd(ei, qx, coefficient(m[3 * i]));
    along_v[i] = hn::MulAdd(ei, qy, coefficient(m[3 * i + 1]));
  }
  Warp warp;
  warp.valid = hn::And(hn::Gt(center[2], hn::Zero(df)), hn::Gt(q, hn::Zero(df)));
  const F inverse =
      hn::Div(hn::Set(df, 1.0f), hn::IfThenElse(warp.valid, center[2], hn::Set(df, 1.0f)));
  warp.x = hn::Mul(center[0], inverse);
  warp.y = hn::Mul(center[1], inverse);
  warp.tilt_u = hn::Mul(along_u[2], inverse);
  warp.tilt_v = hn::Mul(along_v[2], inverse);
  warp.xu = hn::NegMulAdd(warp.x, warp.tilt_u, hn::Mul(along_u[0], inverse));
  warp.xv = hn::NegMulAdd(warp.x, warp.tilt_v, hn::Mul(along_v[0], inverse));
  warp.yu = hn::NegMulAdd(warp.y, warp.tilt_u, hn::Mul(along_u[1], inverse));
  warp.yv = hn::NegMulAdd(warp.y, warp.tilt_v, hn::Mul(along_v[1], inverse));
  const F stretch = hn::Load(df, patch.stretch + lane);
  for (F* value : {&warp.xu, &warp.xv, &warp.yu, &warp.yv, &warp.tilt_u, &warp.tilt_v}) {
    *value = hn::Mul(*value, stretch);
  }
  const float reach = static_cast<float>(window.half * window.step);
  CheckCorner(source, -reach, -reach, &warp);
  CheckCorner(source, -reach, reach, &warp);
  CheckCorner(source, reach, -reach, &warp);
  CheckCorner(source, reach, reach, &warp);
  // Lanes that are not valid sample the first pixel.
  for (F* value :
       {&warp.x, &warp.y, &warp.xu, &warp.xv, &warp.yu, &warp.yv, &warp.tilt_u, &warp.tilt_v}) {
    *value = hn::IfThenElseZero(warp.valid, *value);
  }
  return warp;
}

HWY_INLINE F ScoreLanes(const PatchPacket& patch, const WindowShape& window, const Warp& warp,
                        const SourceView& source, float noise_variance, size_t lane) {
  F sum = hn::Zero(df), sum_squares = hn::Zero(df), product = hn::Zero(df);
  const PackedSampler<DF, FusedLerp> sampler(*source.image);
  const F half = hn::Set(df, 0.5f);
  const F center_x = hn::Sub(warp.x, half), center_y = hn::Sub(warp.y, half);
  float offsets[kMaxWindowSide];
  for (int i = 0; i < window.Side(); ++i)
    offsets[i] = static_cast<float>((i - window.half) * window.step);
  int sample = 0;
  for (int row = -window.half; row <= window.half; ++row) {
    const F v = hn::Set(df, offsets[row + window.half]);
    const F row_tilt = hn::Mul(warp.tilt_v, v);
    const F row_x = hn::Mul(warp.xv, v), row_y = hn::Mul(warp.yv, v);
    for (int column = -window.half; column <= window.half; ++column, ++sample) {
      const F u = hn::Set(df, offsets[column + window.half]);
      const F r = Expand(hn::MulAdd(warp.tilt_u, u, row_tilt));
      const F x = hn::MulAdd(hn::MulAdd(warp.xu, u, row_x), r, center_x);
      const F y = hn::MulAdd(hn::MulAdd(warp.yu, u, row_y), r, center_y);
      const F value = sampler(x, y);
      const F weighted = hn::Mul(hn::Load(df, patch.weight[sample] + lane), value);
      sum = hn::Add(sum, weighted);
      sum_squares = hn::MulAdd(weighted, value, sum_squares);
      product = hn::MulAdd(hn::Load(df, patch.weighted_gray[sample] + lane), value, product);
    }
  }
  const F noise = hn::Set(df, noise_variance);
  const F variance = hn::NegMulAdd(sum, sum, sum_squares);
  const F reference = hn::Add(hn::Load(df, patch.variance + lane), noise);
  const F floor = hn::Add(hn::Max(variance, hn::Zero(df)), noise);
  const F zncc = hn::Div(product, hn::Sqrt(hn::Mul(reference, floor)));
  return hn::IfThenElse(warp.valid, hn::Min(zncc, hn::Set(df, 1.0f)), hn::Set(df, kInvalidZncc));
}

void ScorePacketImpl(const PatchPacket& patch, const WindowShape& window, const PlanePacket& planes,
                     const SourceView& source, float noise_variance, float* zncc) {
  for (size_t lane = 0; lane < kPacketSize; lane += hn::Lanes(df)) {
    const Warp warp = MakeWarp(patch, window, planes, source, lane);
    hn::StoreU(ScoreLanes(patch, window, warp, source, noise_variance, lane), df, zncc + lane);
  }
}

void BuildPatchImpl(const GrayImage& gray, const PatchWeights& weights, PatchPacket* patch) {
  const WindowShape& window = weights.window;
  const int num_samples = window.NumSamples();
  const float* pixels = gray.pixels.data();
  const I zero = hn::Zero(di), width = hn::Set(di, gray.width);
  const I last_column = hn::Set(di, gray.width - 1), last_row = hn::Set(di, gray.height - 1);
  const F steps = hn::Set(df, static_cast<float>(kColorSteps));
  for (size_t lane = 0; lane < kPacketSize; lane += hn::Lanes(df)) {
    const I column = hn::ConvertTo(di, hn::Load(df, patch->u + lane));
    const I row = hn::ConvertTo(di, hn::Load(df, patch->v + lane));
    const I stretch = hn::ConvertTo(di, hn::Load(df, patch->stretch + lane));
    const F center = hn::GatherIndex(df, pixels, hn::Add(hn::Mul(row, width), column));
    F sum_weights = hn::Zero(df), sum = hn::Zero(df);
    int sample = 0;
    for (int y = -window.half; y <= window.half; ++y) {
      const I wanted_row = hn::Add(row, hn::Mul(stretch, hn::Set(di, y * window.step)));
      const I used_row = hn::Max(zero, hn::Min(wanted_row, last_row));
      const I row_begin = hn::Mul(used_row, width);
      for (int x = -window.half; x <= window.half; ++x, ++sample) {
        const I wanted = hn::Add(column, hn::Mul(stretch, hn::Set(di, x * window.step)));
        const I used = hn::Max(zero, hn::Min(wanted, last_column));
        const auto inside = hn::And(hn::Eq(wanted, used), hn::Eq(wanted_row, used_row));
        const F value = hn::GatherIndex(df, pixels, hn::Add(row_begin, used));
        const I difference = hn::NearestInt(hn::Mul(hn::AbsDiff(value, center), steps));
        const F color = hn::GatherIndex(df, weights.color.data(), difference);
        const F weight = hn::IfThenElseZero(
            hn::RebindMask(df, inside),
            hn::Mul(color, hn::Set(df, weights.spatial[static_cast<size_t>(sample)])));
        hn::Store(weight, df, patch->weight[sample] + lane);
        hn::Store(value, df, patch->weighted_gray[sample] + lane);
        sum_weights = hn::Add(sum_weights, weight);
        sum = hn::MulAdd(weight, value, sum);
      }
    }
    const F scale = hn::Div(hn::Set(df, 1.0f), sum_weights), mean = hn::Mul(sum, scale);
    F variance = hn::Zero(df);
    for (sample = 0; sample < num_samples; ++sample) {
      const F weight = hn::Mul(hn::Load(df, patch->weight[sample] + lane), scale);
      const F centered = hn::Sub(hn::Load(df, patch->weighted_gray[sample] + lane), mean);
      const F weighted = hn::Mul(weight, centered);
      hn::Store(weight, df, patch->weight[sample] + lane);
      hn::Store(weighted, df, patch->weighted_gray[sample] + lane);
      variance = hn::MulAdd(weighted, centered, variance);
    }
    hn::Store(variance, df, patch->variance + lane);
  }
}

const char* TargetImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace lsmvs
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cmath>

namespace lsmvs {

HWY_EXPORT(ScorePacketImpl);
HWY_EXPORT(BuildPatchImpl);
HWY_EXPORT(TargetImpl);

PatchWeights::PatchWeights(const WindowShape& shape, double sigma_px, double sigma_gray)
    : window(shape) {
  for (int row = -window.half; row <= window.half; ++row) {
    for (int column = -window.half; column <= window.half; ++column) {
      const double squared = (row * row + column * column) * double(window.step) * window.step;
      spatial.push_back(static_cast<float>(std::exp(-squared / (2 * sigma_px * sigma_px))));
    }
  }
  for (int i = 0; i <= 256 * kColorSteps; ++i) {
    const double difference = static_cast<double>(i) / kColorSteps / sigma_gray;
    color.push_back(static_cast<float>(std::exp(-0.5 * difference * difference)));
  }
}

void BuildPatch(const GrayImage& gray, const PatchWeights& weights, const PacketPixels& pixels,
                PatchPacket* patch) {
  for (int lane = 0; lane < kPacketSize; ++lane) {
    patch->u[lane] = static_cast<float>(pixels[static_cast<size_t>(lane)].column) + 0.5f;
    patch->v[lane] = static_cast<float>(pixels[static_cast<size_t>(lane)].row) + 0.5f;
    patch->stretch[lane] = 1;
  }
  HWY_DYNAMIC_DISPATCH(BuildPatchImpl)(gray, weights, patch);
  bool any_plain = false;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    const bool plain = patch->variance[lane] < weights.min_variance;
    patch->stretch[lane] = plain ? 2 : 1;
    any_plain |= plain;
  }
  if (any_plain) HWY_DYNAMIC_DISPATCH(BuildPatchImpl)(gray, weights, patch);
}

void ScorePacket(const PatchPacket& patch, const WindowShape& window, const PlanePacket& planes,
                 const SourceView& source, float noise_variance, float* zncc) {
  HWY_DYNAMIC_DISPATCH(ScorePacketImpl)(patch, window, planes, source, noise_variance, zncc);
}

const char* ScorePacketTarget() { return HWY_DYNAMIC_DISPATCH(TargetImpl)(); }

}  // namespace lsmvs
#endif
