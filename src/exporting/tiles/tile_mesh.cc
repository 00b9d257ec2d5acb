#include "lsmvs/exporting/tiles/tile_mesh.h"

#include <cmath>

namespace lsmvs {

double MeanTexelSize(const TriangleMesh& mesh,
                     const std::vector<std::array<Eigen::Vector2f, 3>>& texcoords) {
  double area = 0, texels = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    area += 0.5 * FaceNormalTimesTwiceArea(mesh, f).norm();
    texels += TriangleArea(texcoords[f]);
  }
  return texels > 0 ? std::sqrt(area / texels) : 0;
}

double MeanEdgeLength(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& f : mesh.faces) {
    for (int c = 0; c < 3; ++c) sum += (mesh.vertices[f[(c + 1) % 3]] - mesh.vertices[f[c]]).norm();
  }
  return mesh.faces.empty() ? 0 : sum / (3 * static_cast<double>(mesh.faces.size()));
}

}  // namespace lsmvs
