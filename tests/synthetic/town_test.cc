#include "lsmvs/synthetic/town.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "lsmvs/synthetic/mesh_shape.h"

namespace lsmvs {
namespace {

TownOptions Exact() {
  TownOptions options;
  options.num_points = 3e5;
  options.noise_px = options.outlier_fraction = 0;
  return options;
}

VisibilityCloud Sample(const Town& town, int num_threads) {
  VisibilityCloud cloud;
  SampleTown(town, town.MakeViews(), RunContext(num_threads),
             [&](const VisibilityCloud& part) { cloud.Append(part); });
  return cloud;
}

TEST(Town, PointsLieOnTheTruth) {
  const Town town(Exact());
  const TriangleMesh mesh = town.Mesh(0, town.lots_per_side());
  const MeshShape truth(mesh);
  const VisibilityCloud cloud = town.SampleLot(1, town.MakeViews());
  ASSERT_GT(cloud.size(), 1000u);
  for (size_t p = 0; p < cloud.size(); p += 37) {
    const SurfacePoint closest = truth.Closest(cloud.positions[p].cast<double>());
    EXPECT_LT(std::abs(closest.signed_distance), 1e-4) << p;
  }
}

TEST(Town, ViewsOfAPointHaveItInTheirImageAndNothingBetween) {
  const Town town(Exact());
  const Scene scene = town.MakeViews();
  const VisibilityCloud cloud = town.SampleLot(0, scene);
  for (size_t p = 0; p < cloud.size(); p += 37) {
    const Eigen::Vector3d x = (cloud.positions[p] + 1e-2f * cloud.normals[p]).cast<double>();
    EXPECT_GE(cloud.ViewsOf(p).size(), 2u);
    EXPECT_LE(cloud.ViewsOf(p).size(), Town::kMaxViews);
    for (const uint32_t v : cloud.ViewsOf(p)) {
      const View& view = scene.views[v];
      const Eigen::Vector3d in_cam = view.cam_from_world * x;
      EXPECT_GT(in_cam.z(), 0);
      EXPECT_TRUE(view.camera.Contains(view.camera.Project(in_cam)));
      EXPECT_FALSE(town.Hides(x, view.CenterInWorld()));
    }
  }
}

TEST(Town, HasAboutAsManyPointsAsAskedForWhateverTheThreads) {
  const Town town(Exact());
  const VisibilityCloud one = Sample(town, 1), two = Sample(town, 2);
  EXPECT_NEAR(static_cast<double>(one.size()), 3e5, 1e5);
  EXPECT_EQ(one.positions, two.positions);
  EXPECT_EQ(one.view_idxs, two.view_idxs);
}

TEST(Town, OutliersAreAsManyAsAskedFor) {
  TownOptions options = Exact();
  options.outlier_fraction = 0.3;
  const VisibilityCloud exact = Sample(Town(Exact()), 2), cloud = Sample(Town(options), 2);
  ASSERT_GT(cloud.size(), 0u);
  const Town town(options);
  const MeshShape truth(town.Mesh(0, town.lots_per_side()));
  size_t num_off = 0, count = 0;
  for (size_t p = 0; p < cloud.size(); p += 101) {
    ++count;
    num_off += std::abs(truth.Closest(cloud.positions[p].cast<double>()).signed_distance) > 0.01;
  }
  EXPECT_NEAR(static_cast<double>(num_off) / static_cast<double>(count), 0.3, 0.03);
}

}  // namespace
}  // namespace lsmvs
