#include "lsmvs/stereo/patch_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/stereo/patch_kernel.cc"
#include <hwy/foreach_target.h>
// clang-format off
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace lsmvs {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, kPacketSize>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using DI64 = hn::Repartition<int64_t, DF>;
using DU64 = hn::Repartition<uint64_t, DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;
constexpr DF df;
constexpr DI di;
constexpr DU du;

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

// The four pixels of each lane's sample, in two words of two pixels.
HWY_INLINE void GatherQuads(const uint64_t* origin, I index, hn::Vec<DU>* top,
                            hn::Vec<DU>* bottom) {
#if HWY_TARGET == HWY_SCALAR
  const uint64_t quad = origin[hn::GetLane(index)];
  *top = hn::Set(du, static_cast<uint32_t>(quad));
  *bottom = hn::Set(du, static_cast<uint32_t>(quad >> 32));
#else
  constexpr DI64 di64;
  constexpr DU64 du64;
  constexpr hn::Half<DI> di_half;
  const auto low =
      hn::GatherIndex(du64, origin, hn::PromoteTo(di64, hn::LowerHalf(di_half, index)));
  const auto high =
      hn::GatherIndex(du64, origin, hn::PromoteTo(di64, hn::UpperHalf(di_half, index)));
  *top = hn::ConcatEven(du, hn::BitCast(du, high), hn::BitCast(du, low));
  *bottom = hn::ConcatOdd(du, hn::BitCast(du, high), hn::BitCast(du, low));
#endif
}

HWY_INLINE F LowPixel(hn::Vec<DU> word) {
  return hn::ConvertTo(df, hn::BitCast(di, hn::And(word, hn::Set(du, 0xffffu))));
}
HWY_INLINE F HighPixel(hn::Vec<DU> word) {
  return hn::ConvertTo(df, hn::BitCast(di, hn::ShiftRight<16>(word)));
}
HWY_INLINE F Mix(F a, F b, F t) { return hn::MulAdd(t, hn::Sub(b, a), a); }

// Bilinear samples, in units of 1/PackedImage::kScale. Coordinates at least -kPadding.
HWY_INLINE F Sample(const uint64_t* origin, I stride, F x, F y) {
  const F floor_x = hn::Floor(x), floor_y = hn::Floor(y);
  const I index = hn::Add(hn::Mul(hn::ConvertTo(di, floor_y), stride), hn::ConvertTo(di, floor_x));
  hn::Vec<DU> top, bottom;
  GatherQuads(origin, index, &top, &bottom);
  const F a = hn::Sub(x, floor_x), b = hn::Sub(y, floor_y);
  return Mix(Mix(LowPixel(top), HighPixel(top), a), Mix(LowPixel(bottom), HighPixel(bottom), a), b);
}

HWY_INLINE F ScoreLanes(const PatchPacket& patch, const WindowShape& window, const Warp& warp,
                        const SourceView& source, float noise_variance, size_t lane) {
  F sum = hn::Zero(df), sum_squares = hn::Zero(df), product = hn::Zero(df);
  const uint64_t* origin = source.image->Origin();
  const I stride = hn::Set(di, source.image->stride);
  int sample = 0;
  for (int row = -window.half; row <= window.half; ++row) {
    const F v = hn::Set(df, static_cast<float>(row * window.step));
    const F row_tilt = hn::Mul(warp.tilt_v, v);
    const F row_x = hn::Mul(warp.xv, v), row_y = hn::Mul(warp.yv, v);
    for (int column = -window.half; column <= window.half; ++column, ++sample) {
      const F u = hn::Set(df, static_cast<float>(column * window.step));
      const F r = Expand(hn::MulAdd(warp.tilt_u, u, row_tilt));
      const F x = hn::MulAdd(hn::MulAdd(warp.xu, u, row_x), r, warp.x);
      const F y = hn::MulAdd(hn::MulAdd(warp.yu, u, row_y), r, warp.y);
      const F value = Sample(origin, stride, x, y);
      const F weighted = hn::Mul(hn::Load(df, patch.weight[sample] + lane), value);
      sum = hn::Add(sum, weighted);
      sum_squares = hn::MulAdd(weighted, value, sum_squares);
      product = hn::MulAdd(hn::Load(df, patch.weighted_gray[sample] + lane), value, product);
    }
  }
  const F unit = hn::Set(df, 1.0f / PackedImage::kScale), noise = hn::Set(df, noise_variance);
  const F variance = hn::Mul(hn::NegMulAdd(sum, sum, sum_squares), hn::Mul(unit, unit));
  const F reference = hn::Add(hn::Load(df, patch.variance + lane), noise);
  const F floor = hn::Add(hn::Max(variance, hn::Zero(df)), noise);
  const F zncc = hn::Div(hn::Mul(product, unit), hn::Sqrt(hn::Mul(reference, floor)));
  return hn::IfThenElse(warp.valid, hn::Min(zncc, hn::Set(df, 1.0f)), hn::Set(df, kInvalidZncc));
}

void ScorePacketImpl(const PatchPacket& patch, const WindowShape& window, const PlanePacket& planes,
                     const SourceView& source, float noise_variance, float* zncc) {
  for (size_t lane = 0; lane < kPacketSize; lane += hn::Lanes(df)) {
    const Warp warp = MakeWarp(patch, window, planes, source, lane);
    hn::StoreU(ScoreLanes(patch, window, warp, source, noise_variance, lane), df, zncc + lane);
  }
}

const char* TargetImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace lsmvs
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lsmvs {

HWY_EXPORT(ScorePacketImpl);
HWY_EXPORT(TargetImpl);

void ScorePacket(const PatchPacket& patch, const WindowShape& window, const PlanePacket& planes,
                 const SourceView& source, float noise_variance, float* zncc) {
  HWY_DYNAMIC_DISPATCH(ScorePacketImpl)(patch, window, planes, source, noise_variance, zncc);
}

const char* ScorePacketTarget() { return HWY_DYNAMIC_DISPATCH(TargetImpl)(); }

}  // namespace lsmvs
#endif
