#include "lsmvs/mesh/edge_lengths.h"

namespace lsmvs {

double MeanEdgeLength(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& f : mesh.faces) {
    for (int c = 0; c < 3; ++c) sum += (mesh.vertices[f[(c + 1) % 3]] - mesh.vertices[f[c]]).norm();
  }
  return mesh.faces.empty() ? 0 : sum / (3 * static_cast<double>(mesh.faces.size()));
}

}  // namespace lsmvs
