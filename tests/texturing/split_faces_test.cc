#include "lsmvs/texturing/candidates/split_faces.h"

#include <gtest/gtest.h>

#include "lsmvs/test_evaluation/test_meshes.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

namespace lsmvs {
namespace {

using test::DownwardView;
using test::PlaneMesh;

Scene Above(const Eigen::Vector3d& center) {
  Scene scene;
  scene.views.push_back(DownwardView(center));
  scene.views.back().name = "a.png";
  return scene;
}

std::unique_ptr<ImageStore> Images(const Scene& scene) {
  return std::make_unique<ImageStore>(
      std::vector<ImageSource>{{.path = "a.png", .mask_path = "", .camera = scene.views[0].camera}},
      ImageStoreOptions());
}

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    area += 0.5 * FaceNormalTimesTwiceArea(mesh, f).norm();
    EXPECT_GT(FaceNormalTimesTwiceArea(mesh, f).z(), 0);
  }
  return area;
}

TEST(SplitWideFaces, LeavesNoWideFaceAndTheSurfaceAsItIs) {
  const Scene scene = Above({0.5, 0.5, 2});  // sees [-0.5, 1.5]^2 at 100 pixels per unit
  TriangleMesh mesh = PlaneMesh(4, 3, 0, 2);
  EXPECT_GT(SplitWideFaces(scene, *Images(scene), 20, &mesh, RunContext(1)), 10u);
  ExpectValidMesh(mesh);
  EXPECT_NEAR(Area(mesh), 12, 1e-9);
  for (const Eigen::Vector3i& face : mesh.faces) {
    double longest = 0;
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) {
      box.extend(mesh.vertices[face[k]]);
      longest =
          std::max(longest, (mesh.vertices[face[(k + 1) % 3]] - mesh.vertices[face[k]]).norm());
    }
    const bool is_in_photo = box.min().x() < 1.5 && box.min().y() < 1.5;
    EXPECT_LE(100 * longest, is_in_photo ? 20 : 1000);
  }
  // Far from the photo's edge nothing is split.
  EXPECT_LT(mesh.faces.size(), 2000u);
}

// Vertices are added while the views of a face are looked at: where they lie must not matter.
TEST(SplitWideFaces, OfManyViewsIsTheSameWhereverTheVerticesLie) {
  Scene scene = Above({0.5, 0.5, 2});
  for (const double x : {1.0, 1.5, 2.0}) scene.views.push_back(DownwardView({x, 0.5, 2}));
  ImageStore images(std::vector<ImageSource>(
                        4, {.path = "a.png", .mask_path = "", .camera = scene.views[0].camera}),
                    ImageStoreOptions());
  TriangleMesh tight = PlaneMesh(4, 3, 0, 2);
  tight.vertex_quality.assign(tight.vertices.size(), 0.5f);
  TriangleMesh roomy = tight;
  roomy.vertices.reserve(100000);
  tight.vertices.shrink_to_fit();
  SplitWideFaces(scene, images, 20, &tight, RunContext(1));
  SplitWideFaces(scene, images, 20, &roomy, RunContext(1));
  EXPECT_EQ(tight.vertices, roomy.vertices);
  EXPECT_EQ(tight.faces, roomy.faces);
  EXPECT_EQ(tight.vertex_quality, std::vector<float>(tight.vertices.size(), 0.5f));
}

TEST(SplitWideFaces, LeavesSmallFacesAlone) {
  const Scene scene = Above({0.5, 0.5, 2});
  const TriangleMesh input = PlaneMesh(1, 1, 0, 10);
  TriangleMesh mesh = input;
  EXPECT_EQ(SplitWideFaces(scene, *Images(scene), 20, &mesh, RunContext(1)), 0u);
  EXPECT_EQ(mesh.faces, input.faces);
  EXPECT_EQ(mesh.vertices, input.vertices);
}

TEST(SplitWideFaces, EndsForAFaceThatReachesBehindTheCamera) {
  Scene scene = Above({0, 0, 1});
  TriangleMesh mesh;
  mesh.vertices = {{-50, 0.3, 3}, {40, 0.2, -4}, {10, 60, 0}};
  mesh.faces = {{0, 1, 2}};
  SplitWideFaces(scene, *Images(scene), 50, &mesh, RunContext(1));
  EXPECT_LT(mesh.faces.size(), 100000u);
  ExpectValidMesh(mesh);
}

}  // namespace
}  // namespace lsmvs
