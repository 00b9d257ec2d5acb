#include "lsmvs/exporting/files/glb_compression.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "lsmvs/exporting/pages/linear_color.h"

namespace lsmvs {

namespace {

constexpr double kLargest = 65535;

using Quad = std::array<uint16_t, 4>;
using Pair = std::array<uint16_t, 2>;

uint16_t Rounded(double value) {
  return static_cast<uint16_t>(std::lround(std::clamp(value, 0.0, kLargest)));
}

// Values in the vertices' new order, compressed.
template <class Value, class ValueOf>
std::vector<uint8_t> EncodeVertices(const std::vector<unsigned>& new_index, size_t num_vertices,
                                    const ValueOf& value_of) {
  std::vector<Value> values(num_vertices);
  for (size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] != ~0u) values[new_index[v]] = value_of(v);
  }
  std::vector<uint8_t> bytes(meshopt_encodeVertexBufferBound(num_vertices, sizeof(Value)));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), values.data(), num_vertices,
                                          sizeof(Value)));
  return bytes;
}

// Indices of the corners with vertices renumbered; `new_index`: of each vertex, ~0 for unused ones.
std::vector<unsigned> OrderedIndices(const GlbPart& part, std::vector<unsigned>* new_index,
                                     size_t* num_vertices) {
  std::vector<unsigned> indices;
  for (const Eigen::Vector3i& f : part.faces) {
    for (const int v : f) indices.push_back(static_cast<unsigned>(v));
  }
  const size_t count = part.positions.size();
  meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), count);
  new_index->resize(count);
  *num_vertices =
      meshopt_optimizeVertexFetchRemap(new_index->data(), indices.data(), indices.size(), count);
  for (unsigned& index : indices) index = (*new_index)[index];
  return indices;
}

}  // namespace

PositionGrid FindPositionGrid(std::span<const GlbPart> parts) {
  Eigen::AlignedBox3f box;
  for (const GlbPart& part : parts) {
    for (const Eigen::Vector3f& x : part.positions) box.extend(x);
  }
  PositionGrid grid;
  grid.low = box.min().cast<double>();
  const double size = box.sizes().cast<double>().maxCoeff();
  if (size > 0) grid.step = size / kLargest;
  return grid;
}

CompressedPart CompressPart(const GlbPart& part, const PositionGrid& grid) {
  // The formats that the extension is defined by.
  meshopt_encodeVertexVersion(0);
  meshopt_encodeIndexVersion(1);
  CompressedPart result;
  std::vector<unsigned> new_index;
  const std::vector<unsigned> indices = OrderedIndices(part, &new_index, &result.num_vertices);
  result.num_indices = indices.size();
  result.index_bytes = result.num_vertices <= 65535 ? 2 : 4;
  result.low.setConstant(static_cast<int>(kLargest));
  result.high.setZero();
  result.positions = EncodeVertices<Quad>(new_index, result.num_vertices, [&](size_t v) {
    Quad quad{};
    for (int k = 0; k < 3; ++k) {
      const uint16_t q = Rounded((part.positions[v][k] - grid.low[k]) / grid.step);
      result.low[k] = std::min<int>(result.low[k], q);
      result.high[k] = std::max<int>(result.high[k], q);
      quad[static_cast<size_t>(k)] = q;
    }
    return quad;
  });
  if (!part.uv.empty()) {
    result.uv = EncodeVertices<Pair>(new_index, result.num_vertices, [&](size_t v) {
      return Pair{Rounded(kLargest * part.uv[v].x()), Rounded(kLargest * part.uv[v].y())};
    });
  }
  if (!part.colors.empty()) {
    result.colors = EncodeVertices<Quad>(new_index, result.num_vertices, [&](size_t v) {
      const Color& c = part.colors[v];
      return Quad{LinearShort(c[0]), LinearShort(c[1]), LinearShort(c[2]), uint16_t{65535}};
    });
  }
  result.indices.resize(meshopt_encodeIndexBufferBound(indices.size(), result.num_vertices));
  result.indices.resize(meshopt_encodeIndexBuffer(result.indices.data(), result.indices.size(),
                                                  indices.data(), indices.size()));
  return result;
}

}  // namespace lsmvs
