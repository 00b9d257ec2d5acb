#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace lsmvs {

// The vertices of a labelled mesh, once per label that meets at them: what varies over the regions
// of a label and may jump at their seams is given at nodes.
struct LabelNodes {
  std::vector<std::array<int32_t, 3>> of_face;  // #F, of the corners; -1 for faces without label
  std::vector<int32_t> vertex, label;           // #N

  size_t size() const { return vertex.size(); }
  // The node of a face's corner that is at `vertex_idx`; -1 if there is none.
  int32_t At(const Eigen::Vector3i& face, size_t f, int vertex_idx) const {
    for (int k = 0; k < 3; ++k) {
      if (face[k] == vertex_idx) return of_face[f][static_cast<size_t>(k)];
    }
    return -1;
  }
};

// `labels`: #F, -1 for none. Nodes come in the order of the faces. O(#V + #F).
LabelNodes FindLabelNodes(std::span<const Eigen::Vector3i> faces, size_t num_vertices,
                          std::span<const int32_t> labels);

}  // namespace lsmvs
