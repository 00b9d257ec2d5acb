#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lsmvs/scene/depth_map.h"

namespace lsmvs {

// A depth map in half the memory, for caches: depths as they are, normals as 16-bit x and y (z
// follows from the unit length and z < 0). A normal turns by less than 0.003 degrees where it is
// seen at up to 30 degrees, by less than 0.12 at up to 89. Zero normals stay zero.
struct PackedDepthMap {
  static constexpr size_t kBytesPerPixel = sizeof(float) + 2 * sizeof(int16_t);

  Raster<float> depth;
  std::vector<std::array<int16_t, 2>> normals;  // as depth.pixels

  size_t NumBytes() const { return depth.size() * kBytesPerPixel; }
};

PackedDepthMap Pack(DepthMap map);
DepthMap Unpack(const PackedDepthMap& packed);

}  // namespace lsmvs
