#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/exporting/files/glb_file.h"

namespace lsmvs {

// Positions as whole numbers: x = low + step * q, q in 0 .. 65,535. All parts of a model share one,
// so that they still fit each other.
struct PositionGrid {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  double step = 1;
};

PositionGrid FindPositionGrid(std::span<const GlbPart> parts);

// The arrays of a part, quantised, in an order that graphics cards like, and compressed for
// EXT_meshopt_compression.
struct CompressedPart {
  static constexpr size_t kPositionBytes = 8, kUvBytes = 4, kColorBytes = 8;  // of a vertex

  size_t num_vertices = 0, num_indices = 0, index_bytes = 4;  // of each index: 2 or 4
  Eigen::Vector3i low, high;                                  // exact bounds of the positions
  std::vector<uint8_t> positions;  // 3 uint16 and 2 bytes of 0 before compression
  std::vector<uint8_t> uv;         // 2 uint16, 65,535 is 1; or empty
  std::vector<uint8_t> colors;     // 4 uint16 in linear light; or empty
  std::vector<uint8_t> indices;    // triangles
};

// Vertices and faces keep what they are but for the rounding; their order changes. Deterministic.
CompressedPart CompressPart(const GlbPart& part, const PositionGrid& grid);

}  // namespace lsmvs
