#include "lsmvs/surface/visibility_mesher.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/shuffled_cloud.h"
#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

const RunContext kContext(1);

// Holes stay open and nothing moves: the surface as it was cut.
VisibilityMesherOptions Plain() {
  VisibilityMesherOptions options;
  options.merging.max_proj_dist = 1;
  options.cleaning.smoothing_iterations = 0;
  options.cleaning.max_hole_edges = 0;
  options.cleaning.min_spike_factor = 0;
  return options;
}

SampledCloudOptions Points(size_t count) {
  SampledCloudOptions options;
  options.num_points = count;
  return options;
}

struct Meshed {
  SyntheticScene scene;
  VisibilityMesherResult result;
  double Accuracy95() const { return MeasureAccuracy(result.mesh, scene, 2, 5000).p95 / scene.gsd; }
  double AccuracyWithin(double gsds) const {
    return MeasureAccuracy(result.mesh, scene, 2, 5000).Within(gsds * scene.gsd);
  }
  double CompletenessWithin(double gsds) const {
    return MeasureCompleteness(result.mesh, scene, 2, 5000).Within(gsds * scene.gsd);
  }
};

Meshed MeshShapeScene(ShapeName shape, const SampledCloudOptions& sampling,
                      const VisibilityMesherOptions& options = Plain(), int num_views = 16) {
  Meshed meshed{MakeScene(shape, num_views, 320, 240), {}};
  const VisibilityCloud cloud =
      SampleCloud(*meshed.scene.shape, meshed.scene.scene, sampling, kContext);
  meshed.result = MeshVisibilityCloud(meshed.scene.scene, cloud, options, kContext);
  EXPECT_EQ(meshed.result.counters.rays.num_lost_rays, 0u);
  return meshed;
}

// A shape about the origin that half a turn about x does not change, seen from below, too: each
// camera stands once more where that turn takes it.
Meshed MeshShapeSeenAllAround(ShapeName shape, const SampledCloudOptions& sampling,
                              const VisibilityMesherOptions& options = Plain(),
                              int num_views = 16) {
  Meshed meshed{MakeScene(shape, num_views, 320, 240), {}};
  const Rigid3 turn(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(),
                    Eigen::Vector3d::Zero());
  std::vector<View>& views = meshed.scene.scene.views;
  for (int v = 0; v < num_views; ++v) {
    View view = views[static_cast<size_t>(v)];
    view.cam_from_world = view.cam_from_world * turn;
    view.name = "below/" + view.name;
    views.push_back(view);
  }
  const VisibilityCloud cloud =
      SampleCloud(*meshed.scene.shape, meshed.scene.scene, sampling, kContext);
  meshed.result = MeshVisibilityCloud(meshed.scene.scene, cloud, options, kContext);
  EXPECT_EQ(meshed.result.counters.rays.num_lost_rays, 0u);
  return meshed;
}

bool SelfIntersects(const TriangleMesh& mesh) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
  Surface surface;
  for (const auto& x : mesh.vertices) surface.add_vertex({x.x(), x.y(), x.z()});
  for (const auto& f : mesh.faces) {
    surface.add_face(Surface::Vertex_index(static_cast<unsigned>(f[0])),
                     Surface::Vertex_index(static_cast<unsigned>(f[1])),
                     Surface::Vertex_index(static_cast<unsigned>(f[2])));
  }
  EXPECT_EQ(surface.number_of_faces(), mesh.faces.size());
  return CGAL::Polygon_mesh_processing::does_self_intersect(surface);
}

TEST(VisibilityMesher, OptionsAreValidAndBounded) {
  VisibilityMesherOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.merging.max_proj_dist = -1;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("max_proj_dist"), std::string::npos);
}

TEST(VisibilityMesher, SphereIsClosedOutwardAndExact) {
  const Meshed sphere = MeshShapeSeenAllAround(ShapeName::kSphere, Points(4000));
  ASSERT_EQ(sphere.result.status, VisibilityMesherStatus::kSuccess) << sphere.result.message;
  ExpectValidMesh(sphere.result.mesh);
  const MeshInspection inspection = Inspect(sphere.result.mesh);
  EXPECT_EQ(inspection.num_components, 1u);
  EXPECT_FALSE(SelfIntersects(sphere.result.mesh));
  EXPECT_LT(sphere.Accuracy95(), 1.0);
  EXPECT_GT(sphere.CompletenessWithin(1), 0.98);
  EXPECT_TRUE(inspection.IsClosed());
  EXPECT_EQ(inspection.Genus(), 0);
  EXPECT_NEAR(inspection.volume, 4.0 / 3 * std::numbers::pi, 0.1);
}

TEST(VisibilityMesher, TorusHasAHole) {
  const Meshed torus = MeshShapeSeenAllAround(ShapeName::kTorus, Points(10000), Plain(), 24);
  ASSERT_EQ(torus.result.status, VisibilityMesherStatus::kSuccess);
  ExpectValidMesh(torus.result.mesh);
  const MeshInspection inspection = Inspect(torus.result.mesh);
  EXPECT_TRUE(inspection.IsClosed());
  EXPECT_EQ(inspection.Genus(), 1);
  EXPECT_NEAR(inspection.volume, 2 * std::numbers::pi * std::numbers::pi * 0.16, 0.02);
  EXPECT_GT(torus.AccuracyWithin(1), 0.98);
  EXPECT_GT(torus.CompletenessWithin(1), 0.98);
}

// A sphere on the ground, of which a broad patch has no points: whole by default, open where only
// what was seen is asked for.
TEST(VisibilityMesher, ClosedKeepsWhatNobodyMeasuredInside) {
  const SyntheticScene scene = MakeScene(ShapeName::kTerrain, 16, 320, 240);
  const VisibilityCloud all = SampleCloud(*scene.shape, scene.scene, Points(30000), kContext);
  VisibilityCloud cloud;
  for (size_t p = 0; p < all.size(); ++p) {
    const Eigen::Vector3f& x = all.positions[p];
    if (x.head<2>().norm() < 0.25f) continue;
    cloud.Add(x, all.normals[p], all.colors[p], all.ViewsOf(p));
  }
  VisibilityMesherOptions options = Plain();
  options.cleaning.max_web_factor = 20;  // believes in no facet across the gap
  const auto border_edges = [&](Completeness completeness) {
    options.cleaning.completeness = completeness;
    const auto result = MeshVisibilityCloud(scene.scene, cloud, options, kContext);
    ExpectValidMesh(result.mesh);
    size_t inside = 0;
    for (const auto& loop : FindBorderLoops(result.mesh)) {
      inside += std::all_of(loop.begin(), loop.end(),
                            [&](int v) { return result.mesh.vertices[v].head<2>().norm() < 0.5; });
    }
    return inside;
  };
  EXPECT_EQ(border_edges(Completeness::kClosed), 0u);
  EXPECT_GE(border_edges(Completeness::kStrict), 1u);
}

TEST(VisibilityMesher, HalfOutliers) {
  SampledCloudOptions sampling = Points(20000);
  sampling.outlier_fraction = 0.5;
  const Meshed sphere = MeshShapeScene(ShapeName::kSphere, sampling);
  ExpectValidMesh(sphere.result.mesh);
  EXPECT_GT(sphere.AccuracyWithin(1), 0.97);
  EXPECT_GT(sphere.CompletenessWithin(2), 0.88);
}

TEST(VisibilityMesher, OutliersAndNoise) {
  const double gsd = MakeScene(ShapeName::kTerrain, 16, 320, 240).gsd;
  SampledCloudOptions sampling = Points(40000);
  sampling.outlier_fraction = 0.3;
  sampling.noise = 2 * gsd;
  const Meshed terrain = MeshShapeScene(ShapeName::kTerrain, sampling);
  ExpectValidMesh(terrain.result.mesh);
  EXPECT_GT(terrain.AccuracyWithin(4), 0.93);
  EXPECT_GT(terrain.CompletenessWithin(4), 0.93);
}

// The vertices stay where they were measured: the mesh is no farther from the truth than they are.
TEST(VisibilityMesher, NoiseOfTwoPixels) {
  const double gsd = MakeScene(ShapeName::kSphere, 16, 320, 240).gsd;
  SampledCloudOptions sampling = Points(20000);
  sampling.noise = 2 * gsd;
  VisibilityMesherOptions options = Plain();
  options.merging.max_proj_dist = 2;
  const Meshed sphere = MeshShapeScene(ShapeName::kSphere, sampling, options);
  ExpectValidMesh(sphere.result.mesh);
  EXPECT_LT(MeasureAccuracy(sphere.result.mesh, sphere.scene, 2, 5000).mean, 2 * gsd);
  EXPECT_GT(sphere.AccuracyWithin(4), 0.85);
  EXPECT_GT(sphere.CompletenessWithin(4), 0.85);
}

TEST(VisibilityMesher, DensityThatVariesByAThousand) {
  SampledCloudOptions sampling = Points(20000);
  sampling.density_ratio = 1000;
  const Meshed sphere = MeshShapeScene(ShapeName::kSphere, sampling);
  ExpectValidMesh(sphere.result.mesh);
  EXPECT_GT(sphere.AccuracyWithin(4), 0.95);
  EXPECT_GT(sphere.CompletenessWithin(4), 0.95);
}

// Two walls 5 pixels apart and a pole 3 pixels thick.
TEST(VisibilityMesher, ThinPartsSurvive) {
  for (const ShapeName shape : {ShapeName::kThinWalls, ShapeName::kPole}) {
    const Meshed thin = MeshShapeScene(shape, Points(20000), Plain(), 16);
    ExpectValidMesh(thin.result.mesh);
    EXPECT_GT(thin.AccuracyWithin(1), 0.98);
    EXPECT_GT(thin.CompletenessWithin(1), 0.98);
  }
}

TEST(VisibilityMesher, ThinPartsSurviveNoiseAndOutliers) {
  for (const ShapeName shape : {ShapeName::kThinWalls, ShapeName::kPole}) {
    SampledCloudOptions sampling = Points(20000);
    sampling.outlier_fraction = 0.1;
    sampling.noise = 0.5 * MakeScene(shape, 16, 320, 240).gsd;
    const Meshed thin = MeshShapeScene(shape, sampling, Plain(), 16);
    ExpectValidMesh(thin.result.mesh);
    EXPECT_GT(thin.AccuracyWithin(2), 0.85);
    EXPECT_GT(thin.CompletenessWithin(2), 0.85);
  }
}

TEST(VisibilityMesher, ThreadsDoNotMatter) {
  const SyntheticScene scene = MakeScene(ShapeName::kTerrain, 9, 320, 240);
  const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, Points(8000), kContext);
  const VisibilityMesherOptions options;
  const auto one = MeshVisibilityCloud(scene.scene, cloud, options, RunContext(1));
  const auto two = MeshVisibilityCloud(scene.scene, cloud, options, RunContext(2));
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, two.mesh.faces);
  EXPECT_EQ(one.view_idxs, two.view_idxs);
}

struct Similarity {
  double scale;
  Eigen::Matrix3d rotation;
  Eigen::Vector3d shift;
};

class Invariance : public testing::TestWithParam<Similarity> {};

// The place of each vertex among `places`: the first one within the distance.
std::vector<int> FindPlaces(const std::vector<Eigen::Vector3d>& vertices,
                            const std::vector<Eigen::Vector3d>& places, double distance) {
  std::vector<int> found;
  for (const Eigen::Vector3d& x : vertices) {
    const auto place = std::ranges::find_if(
        places, [&](const Eigen::Vector3d& y) { return (x - y).norm() <= distance; });
    found.push_back(static_cast<int>(place - places.begin()));
  }
  return found;
}

// The faces by places of their corners, in an order that says nothing of the mesh's.
std::vector<std::array<int, 3>> SortedFaces(const TriangleMesh& mesh,
                                            const std::vector<int>& places) {
  std::vector<std::array<int, 3>> faces;
  for (const Eigen::Vector3i& face : mesh.faces) {
    std::array<int, 3> corners = {places[face[0]], places[face[1]], places[face[2]]};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    faces.push_back(corners);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

TEST_P(Invariance, SameConnectivity) {
  const auto& [scale, rotation, shift] = GetParam();
  const SyntheticScene scene = MakeScene(ShapeName::kSphereOnGround, 12, 320, 240);
  SampledCloudOptions sampling = Points(3000);
  sampling.noise = 0.3 * scene.gsd;  // in general position: what rounding does to planes is chance
  const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, sampling, kContext);
  Scene moved_scene = scene.scene;
  VisibilityCloud moved_cloud = cloud;
  for (View& view : moved_scene.views) {
    const Eigen::Vector3d center = scale * (rotation * view.CenterInWorld()) + shift;
    view.cam_from_world.rotation = view.cam_from_world.rotation * rotation.transpose();
    view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
  }
  for (size_t p = 0; p < cloud.size(); ++p) {
    moved_cloud.positions[p] =
        (scale * (rotation * cloud.positions[p].cast<double>()) + shift).cast<float>();
    moved_cloud.normals[p] = rotation.cast<float>() * cloud.normals[p];
  }
  const auto before = MeshVisibilityCloud(scene.scene, cloud, Plain(), kContext);
  const auto after = MeshVisibilityCloud(moved_scene, moved_cloud, Plain(), kContext);
  ASSERT_EQ(before.mesh.vertices.size(), after.mesh.vertices.size());
  std::vector<Eigen::Vector3d> expected;
  for (const Eigen::Vector3d& x : before.mesh.vertices) {
    expected.push_back(scale * (rotation * x) + shift);
  }
  // The order of vertices and faces is that along a curve, which depends on the frame.
  const double tolerance = 1e-5 * scale;
  const std::vector<int> places = FindPlaces(after.mesh.vertices, expected, tolerance);
  for (const int place : places) ASSERT_LT(static_cast<size_t>(place), expected.size());
  EXPECT_EQ(SortedFaces(after.mesh, places),
            SortedFaces(before.mesh, FindPlaces(expected, expected, 0)));
}

TEST(VisibilityMesher, OrderOfThePointsDoesNotMatter) {
  for (const double quality : {0.05, 0.7, 7.0}) {
    const SyntheticScene scene = MakeScene(ShapeName::kSphereOnGround, 12, 320, 240);
    SampledCloudOptions sampling = Points(6000);
    sampling.noise = scene.gsd;
    sampling.outlier_fraction = 0.3;
    const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, sampling, kContext);
    VisibilityMesherOptions options;
    options.weights.quality_regularization = quality;
    options.find_free_points = true;
    const auto expected = MeshVisibilityCloud(scene.scene, cloud, options, kContext);
    EXPECT_GT(expected.mesh.faces.size(), 1000u);
    for (const uint64_t seed : {1, 2, 3}) {
      const ShuffledCloud shuffled = Shuffle(cloud, seed);
      const auto found = MeshVisibilityCloud(scene.scene, shuffled.cloud, options, kContext);
      EXPECT_EQ(found.mesh.vertices, expected.mesh.vertices);
      EXPECT_EQ(found.mesh.faces, expected.mesh.faces);
      EXPECT_EQ(found.mesh.vertex_colors, expected.mesh.vertex_colors);
      EXPECT_EQ(found.view_idxs, expected.view_idxs);
      for (size_t p = 0; p < cloud.size(); ++p) {
        ASSERT_EQ(found.point_is_free[p], expected.point_is_free[shuffled.origin[p]]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Similarities, Invariance,
    testing::Values(Similarity{1e-3, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()},
                    Similarity{1e3, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()},
                    Similarity{1024, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()},
                    Similarity{
                        1, Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).matrix(),
                        Eigen::Vector3d::Zero()},
                    // What a float holds of a scene that is a million units large and as far away.
                    Similarity{1e6, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(1e6)}));

VisibilityCloud CloudOf(const std::vector<Eigen::Vector3f>& points,
                        const std::vector<uint32_t>& views) {
  VisibilityCloud cloud;
  for (const auto& x : points) cloud.Add(x, Eigen::Vector3f::Zero(), Color::Zero(), views);
  return cloud;
}

// The second call finds what the first one kept, and does not even read the cloud.
TEST(VisibilityMesher, GoesOnBehindStepsThatWereKept) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphere, 16, 640, 480);
  SampledCloudOptions sampling;
  sampling.num_points = 5000;
  const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, sampling, kContext);
  VisibilityMesherOptions options = Plain();
  options.find_free_points = true;
  const TemporaryFolder folder;
  const CheckpointFolder checkpoints(folder.path() / "steps");
  int num_read = 0;
  const auto mesh = [&] {
    return MeshVisibilityCloud(
        scene.scene,
        [&] {
          ++num_read;
          return cloud;
        },
        options, kContext, checkpoints);
  };
  const VisibilityMesherResult whole = MeshVisibilityCloud(scene.scene, cloud, options, kContext);
  const auto expect_same = [&](const VisibilityMesherResult& result, size_t num_steps_found) {
    EXPECT_EQ(result.counters.num_steps_found, num_steps_found);
    EXPECT_EQ(result.counters.num_vertices, whole.counters.num_vertices);
    EXPECT_EQ(result.counters.rays.num_rays, whole.counters.rays.num_rays);
    EXPECT_EQ(result.mesh.vertices, whole.mesh.vertices);
    EXPECT_EQ(result.mesh.faces, whole.mesh.faces);
    EXPECT_EQ(result.mesh.vertex_colors, whole.mesh.vertex_colors);
    EXPECT_EQ(result.view_idxs, whole.view_idxs);
    EXPECT_EQ(result.point_is_free, whole.point_is_free);
  };
  expect_same(mesh(), 0);
  EXPECT_EQ(num_read, 1);
  expect_same(mesh(), 2);  // points and surface
  std::filesystem::remove(folder.path() / "steps" / "surface.finished");
  expect_same(mesh(), 2);  // points and labels
  std::filesystem::remove(folder.path() / "steps" / "surface.finished");
  std::filesystem::remove(folder.path() / "steps" / "labels.finished");
  expect_same(mesh(), 1);
  EXPECT_EQ(num_read, 1);
}

TEST(VisibilityMesher, DegenerateInputHasAStatus) {
  const Scene scene = MakeScene(ShapeName::kSphere, 4, 64, 48).scene;
  const auto status = [&](const std::vector<Eigen::Vector3f>& points,
                          const std::vector<uint32_t>& views) {
    const auto result = MeshVisibilityCloud(scene, CloudOf(points, views), Plain(), kContext);
    EXPECT_FALSE(result.message.empty());
    EXPECT_TRUE(result.mesh.faces.empty());
    return result.status;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(status({}, {}), VisibilityMesherStatus::kNoPoints);
  EXPECT_EQ(status({{nan, 0, 0}, {0, nan, 0}}, {0, 1}), VisibilityMesherStatus::kNoPoints);
  EXPECT_EQ(status({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}}, {}),
            VisibilityMesherStatus::kNoPoints);
  EXPECT_EQ(status({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}, {0, 1}), VisibilityMesherStatus::kDegenerate);
  EXPECT_EQ(status(std::vector<Eigen::Vector3f>(50, {0.1f, 0, 0}), {0, 1}),
            VisibilityMesherStatus::kDegenerate);
  std::vector<Eigen::Vector3f> plane;
  for (int i = 0; i < 100; ++i) {
    const int column = i % 10, row = i / 10;
    plane.emplace_back(0.1f * static_cast<float>(column), 0.1f * static_cast<float>(row), 0.0f);
  }
  EXPECT_EQ(status(plane, {0, 1}), VisibilityMesherStatus::kDegenerate);
}

TEST(VisibilityMesher, CameraAtAPointAndSingleViews) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphere, 8, 160, 120);
  VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, Points(1000), kContext);
  // A camera stands on a vertex; that view's own ray has no length.
  const Eigen::Vector3f center = scene.scene.views[0].CenterInWorld().cast<float>();
  const std::vector<uint32_t> views = {0, 1};
  cloud.Add(center, Eigen::Vector3f::Zero(), Color::Zero(), views);
  const auto result = MeshVisibilityCloud(scene.scene, cloud, Plain(), kContext);
  EXPECT_EQ(result.counters.rays.num_lost_rays, 0u);
  EXPECT_EQ(result.status, VisibilityMesherStatus::kSuccess);
  // Each point seen by its first view alone.
  VisibilityCloud single;
  for (size_t p = 0; p < cloud.size(); ++p) {
    single.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], cloud.ViewsOf(p).first(1));
  }
  const auto one_view = MeshVisibilityCloud(scene.scene, single, Plain(), kContext);
  EXPECT_EQ(one_view.counters.rays.num_lost_rays, 0u);
  EXPECT_NE(one_view.status, VisibilityMesherStatus::kNoPoints);
}

// What hangs between a sphere and the ground behind its rim is a web that nobody saw.
void ExpectWebsDropped(bool with_normals, double SurfaceCleaningOptions::*factor, double value) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphereOnGround, 16, 320, 240);
  VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, Points(8000), kContext);
  if (!with_normals) cloud.normals.assign(cloud.size(), Eigen::Vector3f::Zero());
  VisibilityMesherOptions options = Plain();
  options.cleaning.max_web_factor = options.cleaning.normal_check_factor = 0;
  options.weights.sink_distance_factor = 1;  // makes more of them
  options.cleaning.completeness = Completeness::kStrict;
  const auto kept = MeshVisibilityCloud(scene.scene, cloud, options, kContext);
  options.cleaning.*factor = value;
  const auto cleaned = MeshVisibilityCloud(scene.scene, cloud, options, kContext);
  EXPECT_EQ(kept.counters.cleaning.num_dropped_webs, 0u);
  EXPECT_GT(cleaned.counters.cleaning.num_dropped_webs, 0u);
  EXPECT_LT(cleaned.mesh.faces.size(), kept.mesh.faces.size());
  EXPECT_GE(MeasureAccuracy(cleaned.mesh, scene, 2, 5000).Within(2 * scene.gsd),
            MeasureAccuracy(kept.mesh, scene, 2, 5000).Within(2 * scene.gsd));
  ExpectValidMesh(cleaned.mesh);
}

TEST(VisibilityMesher, NormalsTellWebs) {
  ExpectWebsDropped(true, &SurfaceCleaningOptions::normal_check_factor, 2);
  ExpectWebsDropped(true, &SurfaceCleaningOptions::max_web_factor, 4);
}

TEST(VisibilityMesher, LinesOfSightTellWebsWithoutNormals) {
  ExpectWebsDropped(false, &SurfaceCleaningOptions::max_web_factor, 20);
}

// Nor do crumbs stay that dropped webs leave hanging on the rest by a vertex.
TEST(VisibilityMesher, NoPieceIsSmallerThanAskedFor) {
  SampledCloudOptions sampling = Points(20000);
  sampling.outlier_fraction = 0.3;
  VisibilityMesherOptions options = Plain();
  options.cleaning.max_web_factor = 20;
  const Meshed meshed = MeshShapeScene(ShapeName::kSphereOnGround, sampling, options);
  const MeshComponents components = FindComponents(meshed.result.mesh);
  EXPECT_EQ(components.num_faces.size(), meshed.result.counters.cleaning.num_components);
  for (const size_t num_faces : components.num_faces) {
    EXPECT_GE(num_faces, static_cast<size_t>(options.cleaning.min_component_faces));
  }
}

TEST(VisibilityMesher, VertexViewsFitTheMesh) {
  const Meshed sphere = MeshShapeScene(ShapeName::kSphere, Points(2000));
  const auto& result = sphere.result;
  ASSERT_EQ(result.view_begin.size(), result.mesh.vertices.size() + 1);
  EXPECT_EQ(result.view_begin.back(), result.view_idxs.size());
  EXPECT_EQ(result.mesh.vertex_colors.size(), result.mesh.vertices.size());
  EXPECT_EQ(result.mesh.vertex_normals.size(), result.mesh.vertices.size());
}

TEST(VisibilityMesher, TooLittleMemoryAndCancel) {
  const SyntheticScene scene = MakeScene(ShapeName::kSphere, 4, 64, 48);
  const VisibilityCloud cloud = SampleCloud(*scene.shape, scene.scene, Points(500), kContext);
  RunContext poor(1);
  poor.memory_budget_bytes = 1000;
  EXPECT_THROW(MeshVisibilityCloud(scene.scene, cloud, Plain(), poor), MemoryError);
  const std::atomic<bool> cancel = true;
  RunContext cancelled(1);
  cancelled.cancel = &cancel;
  EXPECT_THROW(MeshVisibilityCloud(scene.scene, cloud, Plain(), cancelled), CancelledError);
}

}  // namespace
}  // namespace lsmvs
