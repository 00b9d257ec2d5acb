#include "lsmvs/refinement/photo/surface_warp.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lsmvs/refinement/photo/surface_warp.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lsmvs {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;

V Blend(V a, V b, V t) { return hn::Add(a, hn::Mul(t, hn::Sub(b, a))); }

// The four pixels around a position and the interpolant there.
struct Cell {
  V top_left, top_right, bottom_left, bottom_right;
};

Cell GatherCell(const float* pixels, int width, VI index) {
  const D d;
  const DI di;
  const VI right = hn::Set(di, 1), below = hn::Set(di, width);
  return {hn::GatherIndex(d, pixels, index), hn::GatherIndex(d, pixels, hn::Add(index, right)),
          hn::GatherIndex(d, pixels, hn::Add(index, below)),
          hn::GatherIndex(d, pixels, hn::Add(hn::Add(index, below), right))};
}

// The pair's constants of one row, in every lane.
struct RowConstants {
  V rx, ry, rz;  // rotation * ray at column 0
  V sx, sy, sz;  // its step per column
  V tx, ty, tz;  // translation
};

RowConstants MakeRow(const InverseDepthTransfer& pair, int row, int begin) {
  const D d;
  const auto set = [&](double value) { return hn::Set(d, static_cast<float>(value)); };
  const Eigen::Vector3d start = pair.homography * Eigen::Vector3d(begin + 0.5, row + 0.5, 1);
  const Eigen::Vector3d step = pair.homography.col(0);
  const Eigen::Vector3d& t = pair.epipole;
  return {set(start.x()), set(start.y()), set(start.z()), set(step.x()), set(step.y()),
          set(step.z()),  set(t.x()),     set(t.y()),     set(t.z())};
}

void WarpLanes(const RowConstants& c, const GrayImage& gray, const Raster<float>& depth_map,
               float tolerance, V column, V depth, float* warped, float* derivative, float* valid) {
  const D d;
  const DI di;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
  const V ax = hn::Add(c.rx, hn::Mul(column, c.sx));
  const V ay = hn::Add(c.ry, hn::Mul(column, c.sy));
  const V az = hn::Add(c.rz, hn::Mul(column, c.sz));
  const V px = hn::Add(hn::Mul(depth, ax), c.tx);
  const V py = hn::Add(hn::Mul(depth, ay), c.ty);
  const V pz = hn::Add(hn::Mul(depth, az), c.tz);
  auto inside = hn::And(hn::Gt(depth, zero), hn::Gt(pz, zero));
  const V inverse = hn::Div(one, hn::IfThenElse(inside, pz, one));
  const V u = hn::Mul(px, inverse), v = hn::Mul(py, inverse);
  const V x = hn::Sub(u, half), y = hn::Sub(v, half);
  const V max_x = hn::Set(d, static_cast<float>(gray.width - 1));
  const V max_y = hn::Set(d, static_cast<float>(gray.height - 1));
  inside = hn::And(inside, hn::And(hn::Ge(x, zero), hn::Ge(y, zero)));
  inside = hn::And(inside, hn::And(hn::Lt(x, max_x), hn::Lt(y, max_y)));
  if (hn::AllFalse(d, inside)) {
    hn::StoreU(zero, d, warped);
    hn::StoreU(zero, d, derivative);
    hn::StoreU(zero, d, valid);
    return;
  }
  const VI column_j = hn::ConvertTo(di, hn::IfThenElseZero(inside, x));
  const VI row_j = hn::ConvertTo(di, hn::IfThenElseZero(inside, y));
  const V a = hn::Sub(x, hn::ConvertTo(d, column_j)), b = hn::Sub(y, hn::ConvertTo(d, row_j));
  const VI index = hn::Add(hn::Mul(row_j, hn::Set(di, gray.width)), column_j);

  const Cell z = GatherCell(depth_map.pixels.data(), gray.width, index);
  const V z_j =
      Blend(Blend(z.top_left, z.top_right, a), Blend(z.bottom_left, z.bottom_right, a), b);
  const V nearest =
      hn::Min(hn::Min(z.top_left, z.top_right), hn::Min(z.bottom_left, z.bottom_right));
  const V difference = hn::Abs(hn::Sub(z_j, pz));
  auto seen =
      hn::And(hn::Gt(nearest, zero), hn::Le(difference, hn::Mul(pz, hn::Set(d, tolerance))));
  seen = hn::And(seen, inside);

  const Cell g = GatherCell(gray.pixels.data(), gray.width, index);
  const V top_step = hn::Sub(g.top_right, g.top_left);
  const V bottom_step = hn::Sub(g.bottom_right, g.bottom_left);
  const V top = hn::Add(g.top_left, hn::Mul(a, top_step));
  const V bottom = hn::Add(g.bottom_left, hn::Mul(a, bottom_step));
  const V per_y = hn::Sub(bottom, top);
  const V per_x = Blend(top_step, bottom_step, b);
  // d(u, v) / d depth = (a_xy - (u, v) a_z) / p_z.
  const V u_step = hn::Mul(hn::Sub(ax, hn::Mul(u, az)), inverse);
  const V v_step = hn::Mul(hn::Sub(ay, hn::Mul(v, az)), inverse);
  const V slope = hn::Add(hn::Mul(per_x, u_step), hn::Mul(per_y, v_step));
  hn::StoreU(hn::IfThenElseZero(seen, hn::Add(top, hn::Mul(b, per_y))), d, warped);
  hn::StoreU(hn::IfThenElseZero(seen, slope), d, derivative);
  hn::StoreU(hn::IfThenElseZero(seen, one), d, valid);
}

void Warp(const InverseDepthTransfer& pair, const GrayImage& gray_j, const Raster<float>& depth_j,
          float depth_tolerance, int row, int begin, int count, const float* depth,
          const WarpedRow& out) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const RowConstants constants = MakeRow(pair, row, begin);
  HWY_ALIGN float depths[HWY_MAX_BYTES / 4];
  HWY_ALIGN float results[3][HWY_MAX_BYTES / 4];
  for (int x = 0; x < count; x += lanes) {
    const V column = hn::Iota(d, static_cast<float>(x));
    if (x + lanes <= count) {
      WarpLanes(constants, gray_j, depth_j, depth_tolerance, column, hn::LoadU(d, depth + x),
                out.warped + x, out.derivative + x, out.valid + x);
      continue;
    }
    const int rest = count - x;
    std::fill(std::copy(depth + x, depth + count, depths), depths + lanes, 0.0f);
    WarpLanes(constants, gray_j, depth_j, depth_tolerance, column, hn::Load(d, depths), results[0],
              results[1], results[2]);
    std::copy(results[0], results[0] + rest, out.warped + x);
    std::copy(results[1], results[1] + rest, out.derivative + x);
    std::copy(results[2], results[2] + rest, out.valid + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace lsmvs
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lsmvs {

HWY_EXPORT(Warp);

void WarpRow(const InverseDepthTransfer& pair, const GrayImage& gray_j,
             const Raster<float>& depth_j, float depth_tolerance, int row, int begin, int count,
             const float* depth, const WarpedRow& out) {
  HWY_DYNAMIC_DISPATCH(Warp)
  (pair, gray_j, depth_j, depth_tolerance, row, begin, count, depth, out);
}

}  // namespace lsmvs
#endif
