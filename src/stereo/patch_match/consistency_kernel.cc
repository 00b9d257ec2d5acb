#include "lsmvs/stereo/patch_match/consistency_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/stereo/patch_match/consistency_kernel.cc"
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
using F = hn::Vec<DF>;
using M = hn::Mask<DF>;
constexpr DF df;
constexpr DI di;

struct Projected {
  F x, y;
  M ahead;
};

HWY_INLINE F Row(const float* m, float e, F u, F v, F q) {
  const F constant = hn::MulAdd(hn::Set(df, e), q, hn::Set(df, m[2]));
  return hn::MulAdd(hn::Set(df, m[0]), u, hn::MulAdd(hn::Set(df, m[1]), v, constant));
}

HWY_INLINE Projected Project(const float* m, const float* e, F u, F v, F q) {
  const F w = Row(m + 6, e[2], u, v, q);
  const M ahead = hn::Gt(w, hn::Zero(df));
  const F inverse = hn::Div(hn::Set(df, 1.0f), hn::IfThenElse(ahead, w, hn::Set(df, 1.0f)));
  return {hn::Mul(Row(m, e[0], u, v, q), inverse), hn::Mul(Row(m + 3, e[1], u, v, q), inverse),
          ahead};
}

void ForwardBackwardErrorImpl(const PatchPacket& patch, const PlanePacket& planes,
                              const SourcePlanes& source, float max_px, float* error_px) {
  const PlaneMap& map = *source.planes;
  static_assert(sizeof(Plane) == 3 * sizeof(float));
  const float* values = &map.pixels[0].q;
  const F zero = hn::Zero(df), half = hn::Set(df, 0.5f), cut = hn::Set(df, max_px);
  const F width = hn::Set(df, static_cast<float>(map.width));
  const F height = hn::Set(df, static_cast<float>(map.height));
  for (size_t lane = 0; lane < kPacketSize; lane += hn::Lanes(df)) {
    const F u = hn::Load(df, patch.u + lane), v = hn::Load(df, patch.v + lane);
    const Projected there =
        Project(source.forward_m, source.forward_e, u, v, hn::Load(df, planes.q + lane));
    M valid =
        hn::And(there.ahead, hn::And(hn::And(hn::Ge(there.x, zero), hn::Lt(there.x, width)),
                                     hn::And(hn::Ge(there.y, zero), hn::Lt(there.y, height))));
    const F x = hn::IfThenElseZero(valid, there.x), y = hn::IfThenElseZero(valid, there.y);
    const F column = hn::Trunc(x), row = hn::Trunc(y);
    const auto pixel =
        hn::Add(hn::Mul(hn::ConvertTo(di, row), hn::Set(di, map.width)), hn::ConvertTo(di, column));
    const auto index = hn::Add(pixel, hn::Add(pixel, pixel));
    const F q = hn::GatherIndex(df, values, index);
    const F qx = hn::GatherIndex(df, values + 1, index),
            qy = hn::GatherIndex(df, values + 2, index);
    valid = hn::And(valid, hn::Gt(q, zero));
    const F dx = hn::Sub(hn::Sub(x, column), half), dy = hn::Sub(hn::Sub(y, row), half);
    const F q_there = hn::MulAdd(qx, dx, hn::MulAdd(qy, dy, q));
    const Projected back = Project(source.backward_m, source.backward_e, x, y, q_there);
    const F du = hn::Sub(back.x, u), dv = hn::Sub(back.y, v);
    const F error = hn::Sqrt(hn::MulAdd(du, du, hn::Mul(dv, dv)));
    valid = hn::And(valid, hn::And(back.ahead, hn::Lt(error, cut)));
    hn::StoreU(hn::IfThenElse(valid, error, cut), df, error_px + lane);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace lsmvs
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace lsmvs {

HWY_EXPORT(ForwardBackwardErrorImpl);

void ForwardBackwardError(const PatchPacket& patch, const PlanePacket& planes,
                          const SourcePlanes& source, float max_px, float* error_px) {
  if (source.planes == nullptr) {
    std::fill_n(error_px, kPacketSize, max_px);
    return;
  }
  HWY_DYNAMIC_DISPATCH(ForwardBackwardErrorImpl)(patch, planes, source, max_px, error_px);
}

}  // namespace lsmvs
#endif
