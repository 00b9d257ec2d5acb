// Bilinear samples of a PackedImage, a vector at a time. Compiled once for each instruction set, by
// Highway's foreach_target.h, hence no ordinary include guard.
#if defined(LSMVS_STEREO_PACKED_SAMPLER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LSMVS_STEREO_PACKED_SAMPLER_INL_H_
#undef LSMVS_STEREO_PACKED_SAMPLER_INL_H_
#else
#define LSMVS_STEREO_PACKED_SAMPLER_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>

#include "lsmvs/stereo/sampling/packed_image.h"

HWY_BEFORE_NAMESPACE();
namespace lsmvs {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// from + t (to - from).
struct FusedLerp {
  template <class F>
  HWY_INLINE F operator()(F t, F from, F to) const {
    return hn::MulAdd(t, hn::Sub(to, from), from);
  }
};
// The same value on every instruction set: product and sum are rounded each.
struct PortableLerp {
  template <class F>
  HWY_INLINE F operator()(F t, F from, F to) const {
    return hn::Add(from, hn::Mul(t, hn::Sub(to, from)));
  }
};

// `FloatTag` is a Highway tag of floats.
template <class FloatTag, class Lerp>
class PackedSampler {
 public:
  using Floats = hn::Vec<FloatTag>;

  HWY_INLINE explicit PackedSampler(const PackedImage& image)
      : cells_(reinterpret_cast<const int32_t*>(image.Origin())),
        stride_(hn::Set(IntTag(), image.stride)),
        origin_(hn::Set(IntTag(), OriginBits(image.stride))) {}

  // Grey values at (x, y) + (0.5, 0.5), where the centre of the first pixel is (0, 0), from
  // -PackedImage::kPadding to as much beyond the other end. Adding kRound leaves the nearest whole
  // number in the low bits: the cell's. The bits of both sums carry those of kRound, which origin_
  // takes away. Halfway between two cells either gives the same value.
  HWY_INLINE Floats operator()(Floats x, Floats y) const {
    constexpr FloatTag f;
    constexpr IntTag i;
    const Floats round = hn::Set(f, kRound), half = hn::Set(f, 0.5f);
    const Floats column = hn::Add(x, round), row = hn::Add(y, round);
    const Ints index =
        hn::Sub(hn::Add(hn::Mul(hn::BitCast(i, row), stride_), hn::BitCast(i, column)), origin_);
    const Floats a = hn::Add(hn::Sub(x, hn::Sub(column, round)), half);
    const Floats b = hn::Add(hn::Sub(y, hn::Sub(row, round)), half);
    const auto cell = hn::BitCast(UintTag(), hn::GatherIndex(i, cells_, index));
    const Lerp lerp;
    const Floats top = lerp(a, Pixel<0>(cell), Pixel<1>(cell));
    return lerp(b, top, lerp(a, Pixel<2>(cell), Pixel<3>(cell)));
  }

 private:
  using IntTag = hn::RebindToSigned<FloatTag>;
  using UintTag = hn::RebindToUnsigned<FloatTag>;
  using Ints = hn::Vec<IntTag>;

  // 1.5 * 2^23: a float of this size counts in ones.
  static constexpr float kRound = 12582912.0f;

  // Bits of kRound as row times the stride plus as column, modulo 2^32 as the vectors compute it.
  static HWY_INLINE int32_t OriginBits(int stride) {
    const uint32_t bits = std::bit_cast<uint32_t>(kRound);
    return static_cast<int32_t>(bits * static_cast<uint32_t>(stride) + bits);
  }

  template <int kWhich>
  static HWY_INLINE Floats Pixel(hn::Vec<UintTag> cell) {
    const auto shifted = hn::ShiftRight<8 * kWhich>(cell);
    const auto byte = kWhich == 3 ? shifted : hn::And(shifted, hn::Set(UintTag(), 255u));
    return hn::ConvertTo(FloatTag(), hn::BitCast(IntTag(), byte));
  }

  const int32_t* cells_;
  Ints stride_, origin_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lsmvs
HWY_AFTER_NAMESPACE();

#endif
