#include "lsmvs/texturing/charts/charts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

ChartLayout FromAbove(int32_t, std::span<const uint32_t>) {
  return {ChartMap::OfAxis(2, true, 10.0), 0, 2};
}

Charts Make(const TriangleMesh& mesh, const std::vector<int32_t>& labels, int max_side) {
  return MakeCharts(mesh, FindFaceNeighbors(mesh.faces, mesh.vertices.size()), labels, max_side,
                    FromAbove);
}

// Every face in one chart, within its rectangle.
void ExpectCharts(const TriangleMesh& mesh, const Charts& charts,
                  const std::vector<int32_t>& labels, int max_side) {
  std::vector<int> count(mesh.faces.size(), 0);
  for (const Chart& chart : charts.charts) {
    EXPECT_LE(chart.size.maxCoeff(), max_side);
    for (const uint32_t f : charts.FacesOf(chart)) {
      ++count[f];
      EXPECT_EQ(labels[f], chart.label);
      for (const int v : mesh.faces[f]) {
        const Eigen::Vector2d x = chart.map(mesh.vertices[v]) - chart.origin.cast<double>();
        EXPECT_GE(x.minCoeff(), 2 - 1e-9);
        EXPECT_LE((x - chart.size.cast<double>()).maxCoeff(), -2 + 1e-9);
      }
    }
  }
  for (size_t f = 0; f < count.size(); ++f) EXPECT_EQ(count[f], labels[f] >= 0 ? 1 : 0);
}

TEST(Charts, AreTheRegionsOfTheLabels) {
  const TriangleMesh mesh = GridMesh(9);
  std::vector<int32_t> labels(mesh.faces.size());
  for (size_t f = 0; f < labels.size(); ++f) {
    const double x = FaceMiddle(mesh, f).x();
    labels[f] = x < 3 ? 5 : x < 5 ? -1 : 5;
  }
  const Charts charts = Make(mesh, labels, 4096);
  ExpectCharts(mesh, charts, labels, 4096);
  EXPECT_EQ(charts.charts.size(), 2u);
}

TEST(Charts, FitThePage) {
  const TriangleMesh mesh = GridMesh(21);
  const std::vector<int32_t> labels(mesh.faces.size(), 0);
  const Charts charts = Make(mesh, labels, 64);
  ExpectCharts(mesh, charts, labels, 64);
  EXPECT_GE(charts.charts.size(), 16u);
}

TEST(Charts, AreSplitWhereTheyFillTheirRectangleBadly) {
  // An L of two thin arms.
  const TriangleMesh mesh = GridMesh(41);
  std::vector<int32_t> labels(mesh.faces.size());
  double filled = 0;
  for (size_t f = 0; f < labels.size(); ++f) {
    const Eigen::Vector3d x = FaceMiddle(mesh, f);
    labels[f] = x.x() < 4 || x.y() < 4 ? 0 : -1;
    filled += labels[f] == 0 ? 50 : 0;  // square texels
  }
  const Charts charts = Make(mesh, labels, 4096);
  ExpectCharts(mesh, charts, labels, 4096);
  double area = 0;
  for (const Chart& chart : charts.charts) area += chart.size.prod();
  EXPECT_GT(filled, 0.75 * area);
  EXPECT_LE(charts.charts.size(), 6u);
}

TEST(ChartMap, KeepsTheOrientationOfWhatItLooksAt) {
  // Counter-clockwise seen from the positive end of the axis; clockwise with y down.
  for (int axis = 0; axis < 3; ++axis) {
    const ChartMap map = ChartMap::OfAxis(axis, true, 2.0);
    Eigen::Vector3d u = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    const Eigen::Vector2d a = map(u), b = map(v);
    EXPECT_NEAR(a.x() * b.y() - a.y() * b.x(), -4, 1e-12);
  }
}

}  // namespace
}  // namespace lsmvs
