#include "lsmvs/exporting/tiles/chart_unfolding.h"

#include <gtest/gtest.h>

#include <map>

#include "lsmvs/exporting/tiles/tile_mesh.h"
#include "lsmvs/exporting_test/textured_blob.h"

namespace lsmvs {
namespace {

bool Inside(const std::array<Eigen::Vector2f, 3>& t, const Eigen::Vector2f& x, float margin) {
  double sign = 0;
  for (size_t c = 0; c < 3; ++c) {
    const Eigen::Vector2f edge = t[(c + 1) % 3] - t[c], to_x = x - t[c];
    const double distance =
        (edge.x() * to_x.y() - edge.y() * to_x.x()) / std::max(1e-12f, edge.norm());
    if (sign == 0) sign = distance > 0 ? 1 : -1;
    if (sign * distance < margin) return false;
  }
  return true;
}

void ExpectGoodCharts(const TriangleMesh& mesh, double texel_size) {
  const std::vector<UnfoldedChart> charts = UnfoldCharts(mesh, texel_size);
  std::vector<int> count(mesh.faces.size(), 0);
  for (const UnfoldedChart& chart : charts) {
    std::map<std::pair<int, int>, int> owner;
    for (size_t i = 0; i < chart.faces.size(); ++i) {
      ++count[chart.faces[i]];
      const auto& t = chart.texcoords[i];
      const double area = 0.5 * FaceNormalTimesTwiceArea(mesh, chart.faces[i]).norm();
      const double stretch = area / (TriangleArea(t) * texel_size * texel_size);
      EXPECT_GE(stretch, 0.99);
      EXPECT_LE(stretch, 1 / 0.34);
      for (const Eigen::Vector2f& x : t) {
        EXPECT_GE(x.minCoeff(), kChartGutterPx - 1e-3f);
        EXPECT_LE(x.x(), static_cast<float>(chart.size.x() - kChartGutterPx) + 1e-3f);
        EXPECT_LE(x.y(), static_cast<float>(chart.size.y() - kChartGutterPx) + 1e-3f);
      }
      for (int y = 0; y < chart.size.y(); ++y) {
        for (int x = 0; x < chart.size.x(); ++x) {
          const Eigen::Vector2f center(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
          if (!Inside(t, center, 0.01f)) continue;
          EXPECT_TRUE(owner.try_emplace({x, y}, static_cast<int>(i)).second) << "overlap";
          EXPECT_EQ(chart.face_of_texel(x, y), static_cast<int>(i));
        }
      }
    }
  }
  for (const int c : count) EXPECT_EQ(c, 1);
}

TEST(ChartUnfolding, BlobWithoutOverlapAndLittleStretch) {
  const TriangleMesh mesh = BlobMesh(0.4);
  ExpectGoodCharts(mesh, 0.05);
  EXPECT_LT(UnfoldCharts(mesh, 0.05).size(), 30u);
}

TEST(ChartUnfolding, PlaneIsOneChart) {
  TriangleMesh mesh;
  for (int v = 0; v < 36; ++v) mesh.vertices.emplace_back(v % 6, 2 * (v / 6), v % 6);
  for (int f = 0; f < 25; ++f) {
    const int a = f / 5 * 6 + f % 5;
    mesh.faces.emplace_back(a, a + 1, a + 7);
    mesh.faces.emplace_back(a, a + 7, a + 6);
  }
  const auto charts = UnfoldCharts(mesh, 0.1);
  ASSERT_EQ(charts.size(), 1u);
  EXPECT_EQ(charts[0].faces.size(), 50u);
  ExpectGoodCharts(mesh, 0.1);
}

// A ramp that winds over itself: all faces look up, but they lie above each other.
TEST(ChartUnfolding, SpiralDoesNotLieOnItself) {
  TriangleMesh mesh;
  for (int i = 0; i <= 60; ++i) {
    const double angle = 0.3 * i;
    for (const double r : {1.0, 2.0}) {
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.02 * i);
    }
  }
  for (int i = 0; i < 60; ++i) {
    mesh.faces.emplace_back(2 * i, 2 * i + 1, 2 * i + 3);
    mesh.faces.emplace_back(2 * i, 2 * i + 3, 2 * i + 2);
  }
  EXPECT_GE(UnfoldCharts(mesh, 0.05).size(), 3u);
  ExpectGoodCharts(mesh, 0.05);
}

TEST(ChartUnfolding, DegenerateFacesAreNoFault) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 1, 3}};
  size_t count = 0;
  for (const UnfoldedChart& chart : UnfoldCharts(mesh, 0.1)) count += chart.faces.size();
  EXPECT_EQ(count, 2u);
}

}  // namespace
}  // namespace lsmvs
