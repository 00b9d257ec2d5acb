#include "lsmvs/evaluation/silhouettes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace lsmvs {
namespace {

// A camera of 400 x 400 at z = -1 with a focal length of 400: at z = 0 it sees [-0.5, 0.5]^2.
View Camera() {
  View view;
  view.camera = {400, 400, 400, 400, 200, 200};
  view.cam_from_world.translation = {0, 0, 1};
  return view;
}

// Squares of 0.01 on z = height(x, y) over [-0.3, 0.3]^2 where keep(x, y) holds at their middle.
TriangleMesh Plate(
    const std::function<bool(double, double)>& keep,
    const std::function<double(double, double)>& height = [](double, double) { return 0.0; }) {
  TriangleMesh mesh;
  for (int row = 0; row <= 60; ++row) {
    for (int column = 0; column <= 60; ++column) {
      const double x = 0.01 * (column - 30), y = 0.01 * (row - 30);
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 60; ++column) {
      if (!keep(0.01 * (column - 29.5), 0.01 * (row - 29.5))) continue;
      const int a = row * 61 + column;
      mesh.faces.emplace_back(a, a + 1, a + 62);
      mesh.faces.emplace_back(a, a + 62, a + 61);
    }
  }
  return mesh;
}

SilhouetteFigures MeasurePlate(const TriangleMesh& mesh) {
  return MeasureSilhouettes(MeshTracer(mesh, RunContext(1)), mesh, {Camera()}, RunContext(1), 1);
}

bool InSquare(double x, double y, double half) { return std::abs(x) < half && std::abs(y) < half; }

TEST(Silhouettes, WholeSquare) {
  const SilhouetteFigures figures = MeasurePlate(Plate([](double, double) { return true; }));
  EXPECT_EQ(figures.num_views, 1u);
  EXPECT_NEAR(figures.coverage, 0.36, 0.005);
  EXPECT_EQ(figures.hole_share, 0);
  EXPECT_EQ(figures.torn_share, 0);
  EXPECT_EQ(figures.crumb_share, 0);
  EXPECT_NEAR(figures.rim, 4, 0.02);
}

TEST(Silhouettes, DiscHasTheRimOfItsBoxOfPixels) {
  const SilhouetteFigures figures =
      MeasurePlate(Plate([](double x, double y) { return std::hypot(x, y) < 0.25; }));
  EXPECT_NEAR(figures.rim, 8 / std::sqrt(std::numbers::pi), 0.1);  // 4.5
}

TEST(Silhouettes, HolesAndWhatIsOpenToTheOutside) {
  // A hole of 0.04, a large one, and a bay.
  const SilhouetteFigures hole =
      MeasurePlate(Plate([](double x, double y) { return !InSquare(x, y, 0.02); }));
  EXPECT_NEAR(hole.hole_share, 0.0016 / (0.36 - 0.0016), 2e-4);
  const SilhouetteFigures large =
      MeasurePlate(Plate([](double x, double y) { return !InSquare(x, y, 0.2); }));
  EXPECT_EQ(large.hole_share, 0);  // 16 % of the picture
  const SilhouetteFigures bay =
      MeasurePlate(Plate([](double x, double y) { return !(std::abs(x) < 0.02 && y < 0); }));
  EXPECT_EQ(bay.hole_share, 0);
  EXPECT_GT(bay.rim, 4.5);
}

TEST(Silhouettes, TornIsWhatADiscOfOnePercentFills) {
  // Slits of 0.01, 4 pixels, are filled by a disc of radius 4; a gap of 0.04 is not.
  const SilhouetteFigures slits = MeasurePlate(Plate(
      [](double x, double) { return std::lround(100 * x + 29.5) % 6 != 0 || std::abs(x) > 0.28; }));
  EXPECT_GT(slits.torn_share, 0.1);
  const SilhouetteFigures gap =
      MeasurePlate(Plate([](double x, double) { return std::abs(x) > 0.02; }));
  EXPECT_LT(gap.torn_share, 1e-3);
}

TEST(Silhouettes, CrumbsAreLumps) {
  const auto all = [](double, double) { return true; };
  const SilhouetteFigures smooth = MeasurePlate(
      Plate(all, [](double x, double y) { return 0.05 * std::sin(5 * x) * std::cos(4 * y); }));
  EXPECT_EQ(smooth.crumb_share, 0);
  const SilhouetteFigures lumps = MeasurePlate(Plate(all, [](double x, double y) {
    return std::lround(100 * x) % 3 == 0 && std::lround(100 * y) % 3 == 0 ? -0.03 : 0.0;
  }));
  EXPECT_GT(lumps.crumb_share, 0.2);
}

TEST(Silhouettes, MeansAreOverTheViewsThatSeeTheMesh) {
  const TriangleMesh mesh = Plate([](double x, double y) { return !InSquare(x, y, 0.02); });
  View aside = Camera();
  aside.cam_from_world.translation.x() = 100;
  const MeshTracer tracer(mesh, RunContext(1));
  const auto one = MeasureSilhouettes(tracer, mesh, {Camera()}, RunContext(1), 1);
  const auto two = MeasureSilhouettes(tracer, mesh, {Camera(), aside}, RunContext(3), 1);
  EXPECT_EQ(two.num_views, 1u);
  EXPECT_EQ(two.hole_share, one.hole_share);
  EXPECT_EQ(MeasureSilhouettes(tracer, mesh, {aside}, RunContext(1)).num_views, 0u);
}

}  // namespace
}  // namespace lsmvs
