#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/area_sampler.h"
#include "lsmvs/synthetic/box_union.h"
#include "lsmvs/synthetic/mesh_shape.h"
#include "lsmvs/synthetic/named_shapes.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

namespace lsmvs {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGsd = 0.01;

Eigen::Vector3d UnitVector(Random* random) { return random->Gaussian3().normalized(); }

struct NamedShape {
  std::string name;
  ShapePtr shape;
};

// Every kind of shape, with parts that are small and large.
std::vector<NamedShape> AllShapes() {
  return {{"sphere", std::make_shared<Sphere>(Eigen::Vector3d(0.3, -0.2, 0.1), 0.8)},
          {"torus", std::make_shared<Torus>(Eigen::Vector3d(-0.1, 0.2, 0.3), 1.0, 0.3)},
          {"capsule", std::make_shared<Capsule>(Eigen::Vector3d(-0.5, 0.1, -0.3),
                                                Eigen::Vector3d(0.6, -0.4, 0.5), 0.2)},
          {"box", MakeShape(ShapeName::kBox, kGsd)},
          {"step", MakeShape(ShapeName::kStep, kGsd)},
          {"thin_walls", MakeShape(ShapeName::kThinWalls, kGsd)},
          {"pole", MakeShape(ShapeName::kPole, kGsd)},
          {"sphere_on_ground", MakeShape(ShapeName::kSphereOnGround, kGsd)},
          {"terrain", MakeShape(ShapeName::kTerrain, kGsd)},
          {"relief", MakeShape(ShapeName::kRelief, kGsd)}};
}

TEST(Shapes, HitsLieOnTheSurfaceAndNothingLiesBefore) {
  for (const auto& [name, shape] : AllShapes()) {
    SCOPED_TRACE(name);
    const Eigen::AlignedBox3d bounds = shape->Bounds();
    Random random(1);
    int num_hits = 0;
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector3d origin =
          bounds.center() + 2.0 * bounds.diagonal().norm() * UnitVector(&random);
      const Eigen::Vector3d target =
          bounds.center() + 0.3 * bounds.diagonal().norm() * random.Uniform() * UnitVector(&random);
      const Eigen::Vector3d direction = (target - origin).normalized();
      const auto hit = shape->Intersect(origin, direction);
      const double reach = hit ? hit->distance : 4.0 * bounds.diagonal().norm();
      for (int s = 1; s < 40; ++s) {
        EXPECT_GT(shape->SignedDistance(origin + reach * s / 40.0 * direction), -1e-9);
      }
      if (!hit) continue;
      ++num_hits;
      const Eigen::Vector3d x = origin + hit->distance * direction;
      EXPECT_NEAR(shape->SignedDistance(x), 0.0, 1e-9);
      EXPECT_NEAR(hit->normal.norm(), 1.0, 1e-12);
      EXPECT_LT(hit->normal.dot(direction), 1e-9);
    }
    EXPECT_GT(num_hits, 30);
  }
}

TEST(Shapes, ClosestPointIsOnTheSurfaceAtTheDistanceThatItClaims) {
  for (const auto& [name, shape] : AllShapes()) {
    SCOPED_TRACE(name);
    const Eigen::AlignedBox3d bounds = shape->Bounds();
    Random random(2);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector3d x =
          bounds.center() + bounds.diagonal().norm() * random.Uniform() * UnitVector(&random);
      const SurfacePoint closest = shape->Closest(x);
      EXPECT_NEAR((closest.position - x).norm(), std::abs(closest.signed_distance), 1e-9);
      EXPECT_NEAR(closest.normal.norm(), 1.0, 1e-12);
    }
  }
}

TEST(Shapes, ClosestAgreesWithTheNearestOfManySurfacePoints) {
  for (const auto& [name, shape] : AllShapes()) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = shape->Mesh(shape->Bounds().diagonal().norm() / 40);
    const AreaSampler sampler(mesh);
    Random random(3);
    std::vector<Eigen::Vector3d> on_surface;
    for (int i = 0; i < 4000; ++i) {
      on_surface.push_back(shape->Closest(sampler.Draw(&random).position).position);
    }
    const Eigen::AlignedBox3d bounds = shape->Bounds();
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d x =
          bounds.center() + 0.7 * bounds.diagonal().norm() * UnitVector(&random);
      double nearest = 1e300;
      for (const Eigen::Vector3d& p : on_surface) nearest = std::min(nearest, (p - x).norm());
      const double distance = shape->SignedDistance(x);
      EXPECT_LE(distance, nearest + 1e-9);
      EXPECT_GE(distance, nearest - 0.1 * bounds.diagonal().norm());
    }
  }
}

TEST(Shapes, MeshVerticesLieOnTheSurface) {
  for (const auto& [name, shape] : AllShapes()) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = shape->Mesh(shape->Bounds().diagonal().norm() / 30);
    const Eigen::AlignedBox3d bounds = shape->Bounds();
    for (size_t v = 0; v < mesh.vertices.size(); v += 7) {
      // Vertices of a union may be hidden in another part: never outside.
      EXPECT_LT(shape->SignedDistance(mesh.vertices[v]), 1e-9);
      EXPECT_LT(bounds.squaredExteriorDistance(mesh.vertices[v]), 1e-18);
    }
  }
}

TEST(Sphere, MeshHasTheAreaVolumeAndGenusOfASphere) {
  const double radius = 0.7;
  const TriangleMesh mesh = Sphere({1, 2, 3}, radius).Mesh(0.03);
  ExpectValidClosedMesh(mesh);
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_EQ(inspection.Genus(), 0);
  EXPECT_NEAR(inspection.area / (4 * kPi * radius * radius), 1.0, 1e-3);
  EXPECT_NEAR(inspection.volume / (4.0 / 3.0 * kPi * std::pow(radius, 3)), 1.0, 1e-3);
}

TEST(Sphere, MeshEdgesKeepToTheLength) {
  for (const double edge_length : {2.0, 0.5, 0.1, 0.05}) {
    const TriangleMesh mesh = Sphere({0, 0, 0}, 1.0).Mesh(edge_length);
    double longest = 0;
    for (const Eigen::Vector3i& f : mesh.faces) {
      for (int k = 0; k < 3; ++k) {
        longest = std::max(longest, (mesh.vertices[f[k]] - mesh.vertices[f[(k + 1) % 3]]).norm());
      }
    }
    EXPECT_LE(longest, 1.1 * edge_length);
    EXPECT_GE(longest, std::min(1.0, 0.4 * edge_length));
  }
}

TEST(Torus, MeshHasTheAreaVolumeAndGenusOfATorus) {
  const TriangleMesh mesh = Torus({0, 1, 0}, 1.0, 0.4).Mesh(0.03);
  ExpectValidClosedMesh(mesh);
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_EQ(inspection.Genus(), 1);
  EXPECT_NEAR(inspection.area / (4 * kPi * kPi * 0.4), 1.0, 2e-3);
  EXPECT_NEAR(inspection.volume / (2 * kPi * kPi * 0.16), 1.0, 2e-3);
}

TEST(Torus, RayThroughTheHoleMisses) {
  const Torus torus({0, 0, 0}, 1.0, 0.4);
  EXPECT_FALSE(torus.Intersect({0, 0, 5}, {0, 0, -1}));
  const auto hit = torus.Intersect({1, 0, 5}, {0, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 4.6, 1e-9);
}

TEST(Capsule, MeshHasTheAreaAndVolumeOfACapsule) {
  const Eigen::Vector3d a(-0.5, 0.1, -0.3), b(0.6, -0.4, 0.5);
  const double radius = 0.2, length = (b - a).norm();
  const TriangleMesh mesh = Capsule(a, b, radius).Mesh(0.02);
  ExpectValidClosedMesh(mesh);
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_EQ(inspection.Genus(), 0);
  EXPECT_NEAR(inspection.area / (2 * kPi * radius * length + 4 * kPi * radius * radius), 1.0, 3e-3);
  EXPECT_NEAR(
      inspection.volume / (kPi * radius * radius * length + 4.0 / 3.0 * kPi * std::pow(radius, 3)),
      1.0, 5e-3);
}

TEST(BoxUnion, MeshesAreExactAtAnyResolution) {
  for (const double edge_length : {1e9, 0.5, 0.11}) {
    const TriangleMesh box = MakeShape(ShapeName::kBox, kGsd)->Mesh(edge_length);
    ExpectValidClosedMesh(box);
    EXPECT_NEAR(Inspect(box).volume, 2.0 * 1.6 * 1.2, 1e-12);
    EXPECT_NEAR(Inspect(box).area, 2 * (2.0 * 1.6 + 2.0 * 1.2 + 1.6 * 1.2), 1e-12);
    const TriangleMesh step = MakeShape(ShapeName::kStep, kGsd)->Mesh(edge_length);
    ExpectValidClosedMesh(step);
    EXPECT_NEAR(Inspect(step).volume, 3.0 * 3.0 * 0.5 + 1.5 * 3.0 * 0.3, 1e-12);
  }
}

TEST(BoxUnion, TwoSeparateBoxesKeepTheirGap) {
  const ShapePtr walls = MakeShape(ShapeName::kThinWalls, kGsd);
  EXPECT_NEAR(walls->SignedDistance({0, 0, 0.5}), 2.5 * kGsd, 1e-12);
  EXPECT_NEAR(walls->SignedDistance({0, 4 * kGsd, 0.5}), -1.5 * kGsd, 1e-12);
  ExpectValidClosedMesh(walls->Mesh(0.1));
}

TEST(BoxUnion, TouchingBoxesHaveNoWallBetweenThem) {
  const BoxUnion pair({{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1)},
                       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(2, 1, 1)}});
  ExpectValidClosedMesh(pair.Mesh(10));
  EXPECT_NEAR(Inspect(pair.Mesh(10)).area, 10.0, 1e-12);
  EXPECT_NEAR(pair.SignedDistance({1, 0.5, 0.5}), -0.5, 1e-12);
}

TEST(MeshShape, AgreesWithTheSphereThatItWasMadeFrom) {
  const Sphere sphere({0, 0, 0}, 1.0);
  const MeshShape mesh(sphere.Mesh(0.05));
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d x = random.Uniform(0.2, 2.0) * UnitVector(&random);
    EXPECT_NEAR(mesh.SignedDistance(x), sphere.SignedDistance(x), 5e-4);
    const Eigen::Vector3d origin = 3.0 * UnitVector(&random);
    const Eigen::Vector3d direction = (0.5 * UnitVector(&random) - origin).normalized();
    const auto expected = sphere.Intersect(origin, direction);
    const auto found = mesh.Intersect(origin, direction);
    ASSERT_TRUE(expected && found);
    EXPECT_NEAR(found->distance, expected->distance, 1e-3);
  }
}

TEST(MeshShape, NoRaySlipsThroughEdgesAndVertices) {
  const MeshShape mesh(Sphere({0, 0, 0}, 1.0).Mesh(0.5));
  const Eigen::Vector3d origin(0, 0, 4);
  for (const Eigen::Vector3i& f : mesh.mesh().faces) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = mesh.mesh().vertices[f[k]];
      const Eigen::Vector3d& b = mesh.mesh().vertices[f[(k + 1) % 3]];
      for (const double share : {0.0, 0.25, 0.5}) {
        const Eigen::Vector3d target = 0.999 * (a + share * (b - a));
        EXPECT_TRUE(mesh.Intersect(origin, (target - origin).normalized()));
      }
    }
  }
}

TEST(MeshShape, AxisParallelRaysAgreeWithBoxes) {
  const ShapePtr box = MakeShape(ShapeName::kBox, kGsd);
  const MeshShape mesh(box->Mesh(0.1));
  for (const double x : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const auto hit = mesh.Intersect({x, 0.0, 5.0}, {0, 0, -1});
    ASSERT_TRUE(hit) << x;
    EXPECT_NEAR(hit->distance, 4.4, 1e-12);
  }
  EXPECT_FALSE(mesh.Intersect({1.01, 0.0, 5.0}, {0, 0, -1}));
}

TEST(NamedShapes, ClosedMeshesOfEveryPart) {
  for (const ShapeName name :
       {ShapeName::kTerrain, ShapeName::kRelief, ShapeName::kPole, ShapeName::kSphereOnGround}) {
    const MeshInspection inspection = Inspect(MakeShape(name, kGsd)->Mesh(0.1));
    EXPECT_EQ(inspection.num_border_edges, 0u);
    EXPECT_EQ(inspection.num_nonmanifold_edges, 0u);
    EXPECT_EQ(inspection.num_nonmanifold_vertices, 0u);
    EXPECT_EQ(inspection.num_misoriented_edges, 0u);
    EXPECT_GT(inspection.volume, 0.0);
  }
}

}  // namespace
}  // namespace lsmvs
