#include "lsmvs/evaluation/mesh_tracer.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lsmvs/test_evaluation/test_meshes.h"

namespace lsmvs {
namespace {

using test::PlaneMesh;
using test::SphereMesh;

// Distance to a triangle by brute force over a fine grid of its points.
double SampledDistance(const TriangleMesh& mesh, const Eigen::Vector3d& x, int n) {
  double best = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const double a = static_cast<double>(i) / n, b = static_cast<double>(j) / n;
        const Eigen::Vector3d point = (1 - a - b) * mesh.vertices[face[0]] +
                                      a * mesh.vertices[face[1]] + b * mesh.vertices[face[2]];
        best = std::min(best, (point - x).norm());
      }
    }
  }
  return best;
}

TEST(MeshTracer, RayMeetsPlaneWhereItShould) {
  const MeshTracer tracer(PlaneMesh(2, 2, 1), RunContext(1));
  const auto hit = tracer.Cast({0.5, 0.5, 5}, {0, 0, -2});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 2, 1e-6);
  EXPECT_FALSE(tracer.Cast({3, 3, 5}, {0, 0, -1}));
  EXPECT_FALSE(tracer.Cast({0.5, 0.5, 5}, {0, 0, -1}, 0, 3.9));
  EXPECT_TRUE(tracer.Occluded({0.5, 0.5, 5}, {0, 0, -1}, 0, 4.1));
  EXPECT_FALSE(tracer.Occluded({0.5, 0.5, 5}, {0, 0, -1}, 0, 3.9));
}

TEST(MeshTracer, HitIsThePointOfTheFace) {
  const TriangleMesh mesh = SphereMesh(1, 16);
  const MeshTracer tracer(mesh, RunContext(1));
  const Eigen::Vector3d origin(0.1, -0.2, 3), direction(0.05, 0.1, -1);
  const auto hit = tracer.Cast(origin, direction);
  ASSERT_TRUE(hit);
  const Eigen::Vector3i& f = mesh.faces[hit->face];
  const double b1 = hit->barycentric_1, b2 = hit->barycentric_2;
  const Eigen::Vector3d x =
      (1 - b1 - b2) * mesh.vertices[f[0]] + b1 * mesh.vertices[f[1]] + b2 * mesh.vertices[f[2]];
  EXPECT_LT((x - (origin + hit->distance * direction)).norm(), 1e-5);
}

TEST(MeshTracer, ClosestAgreesWithBruteForce) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  TriangleMesh mesh;
  for (int i = 0; i < 30; ++i)
    mesh.vertices.emplace_back(uniform(random), uniform(random), uniform(random));
  for (int i = 0; i < 10; ++i) mesh.faces.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  mesh.faces.emplace_back(0, 0, 1);  // a segment
  mesh.faces.emplace_back(5, 5, 5);  // a point
  const MeshTracer tracer(mesh, RunContext(1));
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d x =
        2 * Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
    const auto closest = tracer.Closest(x);
    ASSERT_TRUE(closest);
    EXPECT_NEAR((closest->x_in_world - x).norm(), closest->distance, 1e-6);
    const double sampled = SampledDistance(mesh, x, 60);
    EXPECT_LE(closest->distance, sampled + 1e-6);
    EXPECT_GE(closest->distance, sampled - 0.03);
  }
}

TEST(MeshTracer, ClosestStopsAtTheMaximum) {
  const MeshTracer tracer(PlaneMesh(1, 1, 0), RunContext(1));
  EXPECT_FALSE(tracer.Closest({0.5, 0.5, 1}, 0.99));
  ASSERT_TRUE(tracer.Closest({0.5, 0.5, 1}, 1.01));
  EXPECT_NEAR(tracer.Closest({0.5, 0.5, 1}, 1.01)->distance, 1, 1e-6);
}

TEST(MeshTracer, FarFromTheOriginLosesNothing) {
  const Eigen::Vector3d utm(450000, 5400000, 300);
  const MeshTracer tracer(test::Scaled(PlaneMesh(1, 1, 0), 1, utm), RunContext(1));
  const auto closest = tracer.Closest(utm + Eigen::Vector3d(0.5, 0.5, 0.01));
  ASSERT_TRUE(closest);
  EXPECT_NEAR(closest->distance, 0.01, 1e-7);
}

TEST(MeshTracer, LeavesOutWhatIsNotFinite) {
  TriangleMesh mesh = PlaneMesh(1, 1, 0, 1);
  mesh.vertices.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  mesh.vertices.emplace_back(0, std::numeric_limits<double>::infinity(), 0);
  mesh.faces.insert(mesh.faces.begin(), Eigen::Vector3i(0, 1, 4));
  mesh.faces.emplace_back(0, 1, 5);
  const MeshTracer tracer(mesh, RunContext(1));
  EXPECT_EQ(tracer.num_left_out(), 2u);
  EXPECT_EQ(tracer.num_faces(), 2u);
  const auto hit = tracer.Cast({0.6, 0.2, 1}, {0, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->face, 1);  // counted in the mesh that was given
}

TEST(MeshTracer, EmptyMeshMeetsNothing) {
  const MeshTracer tracer(TriangleMesh{}, RunContext(1));
  EXPECT_FALSE(tracer.Cast({0, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(tracer.Closest({0, 0, 0}));
}

TEST(MeshTracer, DepthIsZInTheCameraFrame) {
  const MeshTracer tracer(PlaneMesh(100, 100, 0), RunContext(2));
  const View view = test::DownwardView({50, 50, 10});
  const Raster<float> depth = TraceDepth(tracer, view.camera, view.cam_from_world, RunContext(2));
  for (const float z : depth.pixels) ASSERT_NEAR(z, 10, 1e-4);
}

}  // namespace
}  // namespace lsmvs
