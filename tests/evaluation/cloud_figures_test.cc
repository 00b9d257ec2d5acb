#include "lsmvs/evaluation/cloud_figures.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lsmvs {
namespace {

// A camera of 20 x 10 pixels at the origin that looks along z: 5 x 3 cells of 4 pixels, the last
// row of which is cut.
View SmallView() {
  View view;
  view.camera = {20, 10, 10, 10, 10, 5};
  return view;
}

Eigen::Vector3d At(double x_px, double y_px, double depth) {
  return depth * SmallView().camera.Ray({x_px, y_px});
}

TEST(CloudFigures, CountsCoveredCells) {
  std::vector<Eigen::Vector3d> points = {At(0.5, 0.5, 1), At(3.9, 3.9, 7),   // one cell
                                         At(4.1, 0.5, 2), At(19.9, 9.9, 1),  // two more
                                         At(25, 5, 1),    At(10, 5, -1)};    // outside, behind
  points.emplace_back(NAN, 0, 1);
  View away = SmallView();
  away.cam_from_world.translation.z() = -100;  // all points lie behind it
  const CloudFigures figures = MeasureCloud(points, {}, {}, {SmallView(), away}, RunContext(2));
  EXPECT_EQ(figures.num_points, 6u);
  EXPECT_DOUBLE_EQ(*figures.coverage, (3.0 / 15 + 0) / 2);
  EXPECT_FALSE(figures.mean_views);
  EXPECT_FALSE(figures.mean_score);
}

TEST(CloudFigures, TellsWhatTheFileTold) {
  const CloudFigures figures =
      MeasureCloud({At(1, 1, 1), At(2, 2, 1)}, {3, 6}, {0.5f, 1.0f}, {}, RunContext(1));
  EXPECT_DOUBLE_EQ(*figures.mean_views, 4.5);
  EXPECT_DOUBLE_EQ(*figures.mean_score, 0.75);
  EXPECT_FALSE(figures.coverage);
}

}  // namespace
}  // namespace lsmvs
