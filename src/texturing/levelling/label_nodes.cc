#include "lsmvs/texturing/levelling/label_nodes.h"

namespace lsmvs {

LabelNodes FindLabelNodes(std::span<const Eigen::Vector3i> faces, size_t num_vertices,
                          std::span<const int32_t> labels) {
  LabelNodes nodes;
  nodes.of_face.assign(faces.size(), {-1, -1, -1});
  std::vector<int32_t> first(num_vertices, -1), next;  // lists of the nodes of each vertex
  const auto node_of = [&](int vertex, int32_t label) {
    int32_t* link = &first[static_cast<size_t>(vertex)];
    while (*link >= 0) {
      const auto node = static_cast<size_t>(*link);
      if (nodes.label[node] == label) return *link;
      link = &next[node];
    }
    const int32_t node = *link = static_cast<int32_t>(nodes.size());
    nodes.vertex.push_back(vertex);
    nodes.label.push_back(label);
    next.push_back(-1);
    return node;
  };
  for (size_t f = 0; f < faces.size(); ++f) {
    if (labels[f] < 0) continue;
    for (int k = 0; k < 3; ++k) {
      nodes.of_face[f][static_cast<size_t>(k)] = node_of(faces[f][k], labels[f]);
    }
  }
  return nodes;
}

}  // namespace lsmvs
