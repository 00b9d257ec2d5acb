#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lsmvs {

// Items, each of which belongs to a vertex, by vertex. 4 bytes per vertex and an item.
class ByVertex {
 public:
  ByVertex() = default;
  // `vertex_of(item)`: the vertex of each of the items 0 .. num_items - 1.
  template <class VertexOf>
  ByVertex(size_t num_vertices, size_t num_items, const VertexOf& vertex_of)
      : begin_(num_vertices + 1, 0), items_(num_items) {
    for (size_t i = 0; i < num_items; ++i) ++begin_[vertex_of(i) + 1];
    for (size_t v = 0; v < num_vertices; ++v) begin_[v + 1] += begin_[v];
    std::vector<uint32_t> end(begin_.begin(), begin_.end() - 1);
    for (uint32_t i = 0; i < num_items; ++i) items_[end[vertex_of(i)]++] = i;
  }

  // In ascending order.
  std::span<const uint32_t> Of(size_t vertex) const {
    return {items_.data() + begin_[vertex], begin_[vertex + 1] - begin_[vertex]};
  }

 private:
  std::vector<uint32_t> begin_, items_;
};

// The corners of faces, as 3 * face + corner, by the vertex that lies there.
inline ByVertex CornersByVertex(size_t num_vertices, std::span<const Eigen::Vector3i> faces) {
  return ByVertex(num_vertices, 3 * faces.size(),
                  [&](size_t c) { return static_cast<size_t>(faces[c / 3][c % 3]); });
}

}  // namespace lsmvs
