#include "lsmvs/evaluation/atlas_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_evaluation/test_meshes.h"
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
  return MeasureAtlas(TexturePages(textured, size_t{1} << 30), nullptr, RunContext(1));
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

// A photo of a plane, and a page with two copies of it. Faces to the left of a line show the first,
// the others the second, whose colours are multiplied.
AtlasFigures CutPhotoFigures(double gain, const std::function<double(double x, double y)>& gray) {
  const TemporaryFolder folder;
  Scene scene;
  View view = test::DownwardView({1, 0.75, 2.9}, 200, 160, 200);
  view.name = "photo.png";
  view.image_id = ImageId(1);
  ColorImage photo(200, 160), page(400, 160);
  for (int row = 0; row < photo.height; ++row) {
    for (int column = 0; column < photo.width; ++column) {
      const double value = gray(column + 0.5, row + 0.5);
      photo(column, row) = page(column, row) = Color::Constant(static_cast<uint8_t>(value));
      page(200 + column, row) = Color::Constant(static_cast<uint8_t>(gain * value));
    }
  }
  WritePng(folder.path() / view.name, photo);
  WritePng(folder.path() / "page.png", page);
  scene.image_folder = folder.path().string();
  scene.views.push_back(view);
  TexturedMesh textured;
  textured.mesh = test::PlaneMesh(2, 1.5, 0, 20);
  textured.pages = {folder.path() / "page.png"};
  textured.page_width = page.width;
  textured.page_height = page.height;
  for (const Eigen::Vector3i& f : textured.mesh.faces) {
    const auto& v = textured.mesh.vertices;
    const double shift = (v[f[0]] + v[f[1]] + v[f[2]]).x() / 3 < 1 ? 0 : 200;
    std::array<Eigen::Vector2f, 3> corners;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d x_px = view.camera.Project(view.cam_from_world * v[f[k]]);
      corners[static_cast<size_t>(k)] = (x_px + Eigen::Vector2d(shift, 0)).cast<float>();
    }
    textured.texcoords.push_back(corners);
    textured.page_idx.push_back(0);
  }
  const RunContext context(1);
  const MeshTracer tracer(textured.mesh, context);
  const auto images = MakeImageStore(scene, {});
  const SeamPhotos photos = {tracer, scene, *images};
  return MeasureAtlas(TexturePages(textured, size_t{1} << 30), &photos, context);
}

double EvenPattern(double x, double y) {
  return 110 + 40 * std::sin(0.9 * x + 0.7 * y) + 30 * std::sin(1.1 * y - 0.5 * x);
}

TEST(AtlasFigures, OnePhotoInTwoChartsHasNoSeam) {
  const AtlasFigures figures = CutPhotoFigures(1, EvenPattern);
  EXPECT_EQ(figures.num_charts, 2);
  EXPECT_GT(figures.num_seam_samples, 15u);
  EXPECT_NEAR(figures.seam_ratio, 1, 0.1);
  EXPECT_NEAR(figures.photo_ratio, 1, 0.01);
}

// More contrast along the line of the seam, in the photo too: only the comparison with the texture
// inside takes it for a seam.
TEST(AtlasFigures, ContrastOfTheSurfaceAtASeamIsNoSeam) {
  const AtlasFigures figures = CutPhotoFigures(1, [](double x, double y) {
    const double contrast = std::abs(x - 100) < 5 ? 1 : 0.5;
    return 110 + contrast * (EvenPattern(x, y) - 110);
  });
  EXPECT_GT(figures.seam_ratio, 1.5);
  EXPECT_NEAR(figures.photo_ratio, 1, 0.01);
}

TEST(AtlasFigures, AStepOfExposureIsASeam) {
  const AtlasFigures figures = CutPhotoFigures(1.4, EvenPattern);
  EXPECT_GT(figures.seam_ratio, 1.2);
  EXPECT_GT(figures.photo_ratio, 1.2);
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
  const AtlasFigures figures =
      MeasureAtlas(TexturePages(textured, size_t{1} << 30), nullptr, RunContext(1));
  EXPECT_EQ(figures.num_charts, 1);
  EXPECT_EQ(figures.utilisation, 1);
  EXPECT_EQ(figures.num_seam_samples, 0u);
}

}  // namespace
}  // namespace lsmvs
