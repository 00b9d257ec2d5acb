#include "lsmvs/exporting/texture_transfer.h"

#include <gtest/gtest.h>

#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

TEST(TextureTransfer, SimplifiedMeshShowsTheSameColours) {
  const TemporaryFolder folder;
  AtlasOptions options;
  options.page_width = options.page_height = 1024;
  const auto smooth = [](const Eigen::Vector3d& x) -> Color {
    return (128 + 90 * (1.5 * x).array().sin()).matrix().cast<uint8_t>();
  };
  const TexturedMesh textured = PaintAtlas(BlobMesh(0.15), smooth, folder.path(), options);
  const TexturePages pages(textured, size_t{1} << 30);
  const RunContext context(2);
  const MeshTracer tracer(textured.mesh, context);
  const TriangleMesh simple = SimplifyMesh(textured.mesh, 1000, context).mesh;
  for (const double max_texels : {1e6, 2e4}) {  // as fine as the original, and much coarser
    const TransferredTexture texture = TransferTexture(pages, tracer, simple, max_texels, context);
    ASSERT_EQ(texture.texcoords.size(), simple.faces.size());
    double sum = 0;
    for (size_t f = 0; f < simple.faces.size(); ++f) {
      const Eigen::Vector3i& face = simple.faces[f];
      const Eigen::Vector3d middle =
          (simple.vertices[face[0]] + simple.vertices[face[1]] + simple.vertices[face[2]]) / 3;
      const Eigen::Vector2f x =
          (texture.texcoords[f][0] + texture.texcoords[f][1] + texture.texcoords[f][2]) / 3;
      const Eigen::Vector3f truth = smooth(tracer.Closest(middle)->x_in_world).cast<float>();
      sum += (SampleColor(texture.page, x) - truth).cwiseAbs().maxCoeff();
    }
    EXPECT_LT(sum / static_cast<double>(simple.faces.size()), 1.5) << max_texels;
  }
}

}  // namespace
}  // namespace lsmvs
