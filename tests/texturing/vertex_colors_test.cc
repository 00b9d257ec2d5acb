#include "lsmvs/texturing/vertex_colors.h"

#include <gtest/gtest.h>

#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

TEST(VertexColors, AreThoseOfTheSurfaceAndFillWhatNoPhotoSees) {
  const RunContext context(2);
  SyntheticScene s = MakeScene(ShapeName::kSphere, 8, 160, 120);
  s.photo.ambient = 1.0;
  TemporaryFolder folder;
  WritePhotos(*s.shape, s.photo, folder.path().string(), &s.scene, context);
  const auto images = MakeImageStore(s.scene, ImageStoreOptions());
  const TriangleMesh mesh = s.shape->Mesh(0.1);
  const std::vector<Color> colors =
      ColorVertices(s.scene, *images, mesh, VertexColorOptions(), context);
  ASSERT_EQ(colors.size(), mesh.vertices.size());
  const SolidTexture texture(s.photo.texture);
  double error = 0;
  int count = 0;
  for (size_t v = 0; v < colors.size(); ++v) {
    if (mesh.vertices[v].z() < -0.3) continue;
    const Eigen::Vector3f truth = 255 * texture.Albedo(mesh.vertices[v], s.gsd);
    error += (colors[v].cast<float>() - truth).cwiseAbs().mean();
    ++count;
  }
  EXPECT_LT(error / count, 8);
  EXPECT_EQ(colors, ColorVertices(s.scene, *images, mesh, VertexColorOptions(), RunContext(1)));
}

TEST(VertexColors, OptionsHaveBounds) {
  std::string error;
  VertexColorOptions options;
  EXPECT_TRUE(options.Check(&error));
  options.max_views_per_vertex = 0;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_NE(error.find("max_views"), std::string::npos);
}

}  // namespace
}  // namespace lsmvs
