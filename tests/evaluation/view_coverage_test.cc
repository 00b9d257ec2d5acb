#include "lsmvs/evaluation/photos/view_coverage.h"

#include <gtest/gtest.h>

#include "lsmvs/test_evaluation/test_meshes.h"

namespace lsmvs {
namespace {

TEST(ViewCoverage, CountsViewsThatNothingHides) {
  // A small roof at height 5 hides the ground under it from the camera above, not from the one
  // beside.
  TriangleMesh mesh = test::PlaneMesh(10, 10, 0);
  const TriangleMesh roof = test::Scaled(test::PlaneMesh(1, 1, 0), 1, {4.5, 4.5, 5});
  for (const Eigen::Vector3i& f : roof.faces) {
    mesh.faces.push_back(f + Eigen::Vector3i::Constant(static_cast<int>(mesh.vertices.size())));
  }
  mesh.vertices.insert(mesh.vertices.end(), roof.vertices.begin(), roof.vertices.end());
  const MeshTracer tracer(mesh, RunContext(1));
  const std::vector<View> views = {test::DownwardView({5, 5, 10}), test::DownwardView({1, 5, 10})};
  const std::vector<Eigen::Vector3d> points = {
      {5, 5, 0}, {2, 5, 0}, {5, 5, 5}, {40, 5, 0}, {5, 5, 11}};
  EXPECT_EQ(CountViews(points, views, &tracer, 0.01, RunContext(2)),
            (std::vector<int>{1, 2, 1, 0, 0}));
  EXPECT_EQ(CountViews(points, views, nullptr, 0.01, RunContext(2)),
            (std::vector<int>{2, 2, 1, 0, 0}));
  // With a tolerance of more than the height of the roof it hides nothing.
  EXPECT_EQ(CountViews(points, views, &tracer, 6, RunContext(1))[0], 2);
}

TEST(ViewCoverage, SamplingDistanceIsOnePixelOnTheSurface) {
  const std::vector<Eigen::Vector3d> points = {{5, 5, 0}, {5.1, 5, 0}, {4.9, 5, 0}};
  const std::vector<View> views = {test::DownwardView({5, 5, 10}, 200, 200, 250)};
  EXPECT_DOUBLE_EQ(SurfaceSamplingDistance(points, views), 10.0 / 250);
  EXPECT_EQ(SurfaceSamplingDistance(points, {}), 0);
}

}  // namespace
}  // namespace lsmvs
