#include "lsmvs/evaluation/atlas_figures.h"

#include <gtest/gtest.h>

#include <functional>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

// A square of two faces on one page, each with a chart of its own; they meet on the diagonal.
AtlasFigures SquareFigures(const std::function<Color(const Eigen::Vector3d&)>& color) {
  const TemporaryFolder folder;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.faces = {{1, 2, 0}, {3, 0, 2}};
  AtlasOptions options;
  options.page_width = 256;
  options.page_height = 128;
  options.chart_px = 100;
  const TexturedMesh textured = PaintAtlas(mesh, color, folder.path(), options);
  return MeasureAtlas(TexturePages(textured, size_t{1} << 30));
}

TEST(AtlasFigures, CountsChartsAndUtilisation) {
  const AtlasFigures figures = SquareFigures([](const auto&) { return Color(9, 9, 9); });
  EXPECT_EQ(figures.num_pages, 1u);
  EXPECT_EQ(figures.num_charts, 2);
  EXPECT_EQ(figures.num_texels, 256 * 128);
  EXPECT_NEAR(figures.utilisation, 2 * 5000.0 / (256 * 128), 0.01);
  EXPECT_GT(figures.num_seam_samples, 20u);
  EXPECT_EQ(figures.seam_step, 0);
  EXPECT_EQ(figures.seam_ratio, 0);
}

// Colours that go on over the seam: two texels across it differ as two texels inside do.
TEST(AtlasFigures, SmoothColoursHaveNoSeam) {
  const AtlasFigures figures = SquareFigures([](const Eigen::Vector3d& x) {
    const auto ramp = static_cast<uint8_t>(std::lround(20 + 100 * (x.x() - x.y() + 1)));
    return Color(ramp, ramp, ramp);
  });
  EXPECT_NEAR(figures.seam_ratio, 1, 0.05);
  EXPECT_NEAR(figures.seam_step, 100 * std::sqrt(2) * 2 / 100, 0.1);
}

TEST(AtlasFigures, StepAtTheSeamIsMeasured) {
  const AtlasFigures figures = SquareFigures([](const Eigen::Vector3d& x) {
    const double step = x.x() > x.y() ? 30 : 0;
    const auto value = static_cast<uint8_t>(std::lround(20 + step + 50 * (x.x() - x.y() + 1)));
    return Color(value, value, value);
  });
  // Texels whose centres lie beyond the seam show the other side: they mix in a little.
  EXPECT_NEAR(figures.seam_step, 30 + 50 * std::sqrt(2) * 2 / 100, 1.5);
  EXPECT_NEAR(figures.inner_step, 50 * std::sqrt(2) * 2 / 100, 0.1);
}

TEST(AtlasFigures, OneChartHasNoSeam) {
  const TemporaryFolder folder;
  WritePng(folder.path() / "p.png", ColorImage(16, 16, Color(1, 2, 3)));
  TexturedMesh textured;
  textured.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  textured.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  textured.pages = {folder.path() / "p.png"};
  textured.page_width = textured.page_height = 16;
  const Eigen::Vector2f a(0, 0), b(16, 0), c(16, 16), d(0, 16);
  textured.texcoords = {{a, b, c}, {a, c, d}};
  textured.page_idx = {0, 0};
  const AtlasFigures figures = MeasureAtlas(TexturePages(textured, size_t{1} << 30));
  EXPECT_EQ(figures.num_charts, 1);
  EXPECT_EQ(figures.utilisation, 1);
  EXPECT_EQ(figures.num_seam_samples, 0u);
}

}  // namespace
}  // namespace lsmvs
