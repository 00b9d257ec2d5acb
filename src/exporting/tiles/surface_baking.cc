#include "lsmvs/exporting/tiles/surface_baking.h"

#include <Eigen/Geometry>
#include <cmath>

#include "lsmvs/exporting/tiles/chart_unfolding.h"
#include "lsmvs/exporting/tiles/rectangle_packing.h"
#include "lsmvs/geometry/distances.h"
#include "lsmvs/image/hole_filling.h"

namespace lsmvs {

namespace {

Triangle3 TriangleOf(const TriangleMesh& mesh, int face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  return {mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
}

void BakeChart(const UnfoldedChart& chart, const Eigen::Vector2i& corner, const TriangleMesh& mesh,
               const ColorAt& color_at, ColorImage* page, ByteImage* known) {
  for (int y = 0; y < chart.size.y(); ++y) {
    for (int x = 0; x < chart.size.x(); ++x) {
      const int32_t i = chart.face_of_texel(x, y);
      if (i < 0) continue;
      const auto& t = chart.texcoords[static_cast<size_t>(i)];
      const auto lifted = [](const Eigen::Vector2f& p) { return Eigen::Vector3d(p.x(), p.y(), 0); };
      // Beyond the face's edge the weights continue its plane.
      const Eigen::Vector3d weights =
          BarycentricCoordinates({x + 0.5, y + 0.5, 0}, {lifted(t[0]), lifted(t[1]), lifted(t[2])});
      const Triangle3 face = TriangleOf(mesh, chart.faces[static_cast<size_t>(i)]);
      const Eigen::Vector3f color =
          color_at(weights[0] * face.a + weights[1] * face.b + weights[2] * face.c,
                   (face.b - face.a).cross(face.c - face.a));
      const Eigen::Vector2i texel = corner + Eigen::Vector2i(x, y);
      (*page)(texel.x(), texel.y()) = (color.array() + 0.5f).matrix().cast<uint8_t>();
      (*known)(texel.x(), texel.y()) = 1;
    }
  }
}

}  // namespace

BakedSurface BakeSurface(const TriangleMesh& mesh, double texel_size, const ColorAt& color_at,
                         const RunContext& context) {
  const std::vector<UnfoldedChart> charts = UnfoldCharts(mesh, texel_size);
  std::vector<Eigen::Vector2i> sizes;
  for (const UnfoldedChart& chart : charts) sizes.push_back(chart.size);
  const PackedRectangles packed = PackRectangles(sizes);
  BakedSurface baked;
  baked.page = ColorImage(packed.page_size.x(), packed.page_size.y());
  ByteImage known(baked.page.width, baked.page.height, 0);
  ParallelFor(context, charts.size(), 1, [&](size_t c) {
    BakeChart(charts[c], packed.corners[c], mesh, color_at, &baked.page, &known);
  });
  FillHoles(known, &baked.page);
  baked.texcoords.resize(mesh.faces.size());
  for (size_t c = 0; c < charts.size(); ++c) {
    for (size_t i = 0; i < charts[c].faces.size(); ++i) {
      auto& corners = baked.texcoords[static_cast<size_t>(charts[c].faces[i])];
      corners = charts[c].texcoords[i];
      for (Eigen::Vector2f& x : corners) x += packed.corners[c].cast<float>();
    }
  }
  return baked;
}

double TexelSizeFor(const TriangleMesh& mesh, double max_texels) {
  double area = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    area += 0.5 * FaceNormalTimesTwiceArea(mesh, f).norm();
  }
  return std::sqrt(area / max_texels);
}

}  // namespace lsmvs
