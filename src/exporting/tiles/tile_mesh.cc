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

}  // namespace lsmvs
