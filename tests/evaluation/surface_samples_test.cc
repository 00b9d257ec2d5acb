#include "lsmvs/evaluation/samples/surface_samples.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "lsmvs/test_evaluation/test_meshes.h"

namespace lsmvs {
namespace {

TEST(SurfaceSamples, AreUniformOverArea) {
  // A fine and a coarse half of the same area get the same number of points.
  TriangleMesh mesh = test::PlaneMesh(1, 2, 0, 1);
  const TriangleMesh fine = test::PlaneMesh(1, 2, 0, 20);
  const int first = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3d& x : fine.vertices)
    mesh.vertices.push_back(x + Eigen::Vector3d(1, 0, 0));
  for (const Eigen::Vector3i& f : fine.faces)
    mesh.faces.push_back(f + Eigen::Vector3i::Constant(first));
  const size_t n = 40000;
  const auto points = SampleSurface(mesh, n, 1, RunContext(1));
  ASSERT_EQ(points.size(), n);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  size_t right = 0;
  for (const Eigen::Vector3d& x : points) {
    ASSERT_GE(x.minCoeff(), 0);
    mean += x / static_cast<double>(n);
    right += x.x() > 1;
  }
  EXPECT_NEAR(static_cast<double>(right) / n, 0.5, 0.01);  // 4 standard errors
  EXPECT_NEAR(mean.x(), 1, 0.012);
  EXPECT_NEAR(mean.y(), 1, 0.012);
}

TEST(SurfaceSamples, DependOnTheSeedAndNotOnThreads) {
  const TriangleMesh mesh = test::SphereMesh(1, 10);
  const auto one = SampleSurface(mesh, 9000, 5, RunContext(1));
  EXPECT_EQ(one, SampleSurface(mesh, 9000, 5, RunContext(2)));
  EXPECT_NE(one, SampleSurface(mesh, 9000, 6, RunContext(1)));
}

TEST(SurfaceSamples, OfACloudAreDifferentPoints) {
  TriangleMesh cloud;
  for (int i = 0; i < 100; ++i) cloud.vertices.emplace_back(i, 0, 0);
  cloud.vertices.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  EXPECT_EQ(SampleSurface(cloud, 1000, 0, RunContext(1)).size(), 100u);
  std::set<double> different;
  for (const Eigen::Vector3d& x : SampleSurface(cloud, 50, 0, RunContext(1)))
    different.insert(x.x());
  EXPECT_EQ(different.size(), 50u);
}

TEST(SurfaceSamples, OfNothingAreNone) {
  TriangleMesh mesh;
  EXPECT_TRUE(SampleSurface(mesh, 10, 0, RunContext(1)).empty());
  mesh.vertices.assign(3, Eigen::Vector3d::Zero());
  mesh.faces.emplace_back(0, 1, 2);
  EXPECT_TRUE(SampleSurface(mesh, 10, 0, RunContext(1)).empty());
}

TEST(SurfaceSamples, AvoidFacesThatAreNotFinite) {
  TriangleMesh mesh = test::PlaneMesh(1, 1, 0, 1);
  mesh.vertices.emplace_back(std::numeric_limits<double>::infinity(), 0, 0);
  mesh.faces.emplace_back(0, 1, 4);
  for (const Eigen::Vector3d& x : SampleSurface(mesh, 1000, 0, RunContext(1))) {
    ASSERT_TRUE(x.allFinite());
  }
}

}  // namespace
}  // namespace lsmvs
