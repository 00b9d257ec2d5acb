#include "lsmvs/scene/packed_depth_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lsmvs {

namespace {

constexpr float kScale = 32767;
constexpr int16_t kNoNormal = std::numeric_limits<int16_t>::min();  // as x
// Rounding may take x and y beyond the unit circle: z stays negative.
constexpr float kMinSquaredZ = 1e-8f;

std::array<int16_t, 2> PackNormal(const Eigen::Vector3f& normal) {
  if (normal.isZero(0.0f)) return {kNoNormal, 0};
  const auto pack = [](float value) {
    return static_cast<int16_t>(std::lround(kScale * std::clamp(value, -1.0f, 1.0f)));
  };
  return {pack(normal.x()), pack(normal.y())};
}

Eigen::Vector3f UnpackNormal(const std::array<int16_t, 2>& packed) {
  if (packed[0] == kNoNormal) return Eigen::Vector3f::Zero();
  const float x = static_cast<float>(packed[0]) / kScale;
  const float y = static_cast<float>(packed[1]) / kScale;
  return {x, y, -std::sqrt(std::max(kMinSquaredZ, 1 - x * x - y * y))};
}

}  // namespace

PackedDepthMap Pack(DepthMap map) {
  PackedDepthMap packed;
  packed.normals.resize(map.normal.size());
  std::transform(map.normal.pixels.begin(), map.normal.pixels.end(), packed.normals.begin(),
                 PackNormal);
  packed.depth = std::move(map.depth);
  return packed;
}

DepthMap Unpack(const PackedDepthMap& packed) {
  DepthMap map{packed.depth, Raster<Eigen::Vector3f>(packed.depth.width, packed.depth.height)};
  std::transform(packed.normals.begin(), packed.normals.end(), map.normal.pixels.begin(),
                 UnpackNormal);
  return map;
}

}  // namespace lsmvs
