#include "lsmvs/surface/extraction/surface_cleaning.h"

#include <gtest/gtest.h>

#include <vector>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

namespace lsmvs {
namespace {

constexpr SurfaceCleaningOptions kNoRules = {.max_gap_share = 0,
                                             .max_side_length_factor = 0,
                                             .max_web_factor = 0,
                                             .normal_check_factor = 0,
                                             .max_normal_angle_deg = 0,
                                             .max_side_length_percentile = 0,
                                             .min_component_fraction = 0,
                                             .min_component_faces = 0,
                                             .max_hole_edges = 0,
                                             .min_spike_factor = 0,
                                             .smoothing_iterations = 0};

// A sphere and a small one beside it, all of whose vertices are points that all views see.
struct TwoSpheres {
  TwoSpheres() : scene(MakeScene(ShapeName::kSphere, 4, 320, 240)) {
    const TriangleMesh sphere = scene.shape->Mesh(0.3);
    num_large_faces = sphere.faces.size();
    Add(sphere, 1, {0, 0, 0});
    Add(MakeScene(ShapeName::kSphere, 4, 320, 240).shape->Mesh(1), 0.1, {3, 0, 0});
    cloud.sight_begin = {0};
    for (size_t v = 0; v < surface.mesh.vertices.size(); ++v) {
      surface.vertex_point.push_back(static_cast<int32_t>(v));
      cloud.positions.push_back(surface.mesh.vertices[v].cast<float>());
      cloud.normals.push_back(Eigen::Vector3f::Zero());
      cloud.colors.push_back(ColorOf(v));
      for (uint32_t view = 0; view < 4; ++view) cloud.sights.push_back({view, 1});
      cloud.sight_begin.push_back(cloud.sights.size());
    }
  }

  static Color ColorOf(size_t v) {
    return Color(static_cast<uint8_t>(v), static_cast<uint8_t>(v / 256), 7);
  }

  void Add(const TriangleMesh& mesh, double scale, const Eigen::Vector3d& shift) {
    const int first = static_cast<int>(surface.mesh.vertices.size());
    for (const Eigen::Vector3d& x : mesh.vertices) {
      surface.mesh.vertices.push_back(scale * x + shift);
    }
    for (const Eigen::Vector3i& face : mesh.faces) {
      surface.mesh.faces.push_back(face.array() + first);
    }
  }

  SurfaceCleaningCounters Clean(const SurfaceCleaningOptions& options) {
    return CleanSurface(scene.scene, cloud, options, 3, RunContext(2), &surface);
  }

  SyntheticScene scene;
  MergedCloud cloud;
  ExtractedSurface surface;
  size_t num_large_faces = 0;
};

TEST(SurfaceCleaning, WithoutRulesNothingChangesButColors) {
  TwoSpheres spheres;
  const TriangleMesh before = spheres.surface.mesh;
  const SurfaceCleaningCounters counters = spheres.Clean(kNoRules);
  EXPECT_EQ(counters.num_components, 2u);
  EXPECT_EQ(spheres.surface.mesh.vertices, before.vertices);
  EXPECT_EQ(spheres.surface.mesh.faces, before.faces);
  ASSERT_EQ(spheres.surface.mesh.vertex_colors.size(), before.vertices.size());
  for (size_t v = 0; v < before.vertices.size(); ++v) {
    EXPECT_EQ(spheres.surface.mesh.vertex_colors[v], TwoSpheres::ColorOf(v));
  }
}

TEST(SurfaceCleaning, DropsWhatFloatsAndIsSmall) {
  TwoSpheres spheres;
  const size_t num_faces = spheres.surface.mesh.faces.size();
  SurfaceCleaningOptions options = kNoRules;
  options.min_component_fraction = 0.5;
  const SurfaceCleaningCounters counters = spheres.Clean(options);
  EXPECT_EQ(counters.num_components, 1u);
  EXPECT_EQ(counters.num_dropped_components, 1u);
  EXPECT_EQ(counters.num_dropped_component_faces, num_faces - spheres.num_large_faces);
  EXPECT_EQ(spheres.surface.mesh.faces.size(), spheres.num_large_faces);
  EXPECT_EQ(spheres.surface.vertex_point.size(), spheres.surface.mesh.vertices.size());
  EXPECT_TRUE(Inspect(spheres.surface.mesh).IsClosed());
}

TEST(SurfaceCleaning, KeepsTheLargestPieceWhateverIsAskedFor) {
  TwoSpheres spheres;
  SurfaceCleaningOptions options = kNoRules;
  options.min_component_faces = 1 << 30;
  spheres.Clean(options);
  EXPECT_EQ(spheres.surface.mesh.faces.size(), spheres.num_large_faces);
}

TEST(SurfaceCleaning, ClosesHolesUpToTheirSize) {
  TwoSpheres spheres;
  const double volume = Inspect(spheres.surface.mesh).volume;
  spheres.surface.mesh.faces.erase(spheres.surface.mesh.faces.begin());  // a hole of three edges
  SurfaceCleaningOptions options = kNoRules;
  options.max_hole_edges = 3;
  EXPECT_EQ(spheres.Clean(options).num_closed_holes, 1u);
  EXPECT_NEAR(Inspect(spheres.surface.mesh).volume, volume, 1e-9);
  EXPECT_TRUE(Inspect(spheres.surface.mesh).IsClosed());

  // All faces around a vertex: more edges than three.
  auto& faces = spheres.surface.mesh.faces;
  std::erase_if(faces, [](const Eigen::Vector3i& face) { return (face.array() == 10).any(); });
  EXPECT_EQ(spheres.Clean(options).num_closed_holes, 0u);
  EXPECT_FALSE(Inspect(spheres.surface.mesh).IsClosed());
}

TEST(SurfaceCleaning, FacesMuchLongerThanUsualGo) {
  TwoSpheres spheres;
  // A spike: one vertex far out.
  spheres.surface.mesh.vertices[10] *= 30;
  const size_t num_faces = spheres.surface.mesh.faces.size();
  size_t num_spiked = 0;
  for (const Eigen::Vector3i& face : spheres.surface.mesh.faces) {
    num_spiked += (face.array() == 10).any();
  }
  SurfaceCleaningOptions options = kNoRules;
  options.completeness = Completeness::kStrict;
  options.max_side_length_factor = 10;
  options.max_side_length_percentile = 50;
  spheres.Clean(options);
  EXPECT_EQ(spheres.surface.mesh.faces.size(), num_faces - num_spiked);
  for (const Eigen::Vector3d& x : spheres.surface.mesh.vertices) {
    EXPECT_LT(x.norm(), 4) << "of the spike";
  }
}

TEST(SurfaceCleaning, LoneSpikesSink) {
  for (const double factor : {0.0, 2.0}) {
    TwoSpheres spheres;
    spheres.surface.mesh.vertices[10] *= 30;
    SurfaceCleaningOptions options = kNoRules;
    options.max_side_length_percentile = 50;
    options.min_spike_factor = factor;
    const SurfaceCleaningCounters counters = spheres.Clean(options);
    const double radius = spheres.surface.mesh.vertices[10].norm();
    EXPECT_EQ(counters.num_sunk_spikes, factor == 0 ? 0u : 1u);
    EXPECT_NEAR(radius, factor == 0 ? 30 : 1, factor == 0 ? 1 : 0.1);
    // It is no point any more: it has no views, and its neighbours' colour.
    EXPECT_EQ(spheres.surface.vertex_point[10], factor == 0 ? 10 : -1);
    const Color color = spheres.surface.mesh.vertex_colors[10];
    EXPECT_EQ(color == TwoSpheres::ColorOf(10), factor == 0);
    EXPECT_EQ(color[2], 7);
  }
}

}  // namespace
}  // namespace lsmvs
