#include "lsmvs/exporting/texture_transfer.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "lsmvs/exporting/tiles/same_side.h"
#include "lsmvs/exporting/tiles/surface_baking.h"
#include "lsmvs/exporting/tiles/tile_mesh.h"
#include "lsmvs/geometry/distances.h"

namespace lsmvs {

namespace {

constexpr int kMostSamples = 4;  // per axis of a texel
constexpr double kReachTexels = 64;

class SourceTexture {
 public:
  SourceTexture(const TexturePages& pages, const MeshTracer& tracer, double texel_size)
      : pages_(pages),
        textured_(pages.textured()),
        tracer_(tracer),
        reach_(kReachTexels * texel_size) {
    for (size_t f = 0; f < textured_.mesh.faces.size(); ++f) {
      const double texels = TriangleArea(textured_.texcoords[f]);
      const double area = 0.5 * FaceNormalTimesTwiceArea(textured_.mesh, f).norm();
      const double ratio = texels > 0 && area > 0 ? texel_size / std::sqrt(area / texels) : 1;
      texels_wide_.push_back(static_cast<float>(std::clamp(ratio, 1.0, 32.0)));
    }
  }

  Eigen::Vector3f At(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
    const std::optional<ClosestPoint> nearest =
        ClosestOnSameSide(tracer_, textured_.mesh, x, normal, reach_);
    if (!nearest) return Eigen::Vector3f::Zero();
    const size_t face = static_cast<size_t>(nearest->face);
    const Eigen::Vector3i& f = textured_.mesh.faces[face];
    const Eigen::Vector3d weights = BarycentricCoordinates(
        nearest->x_in_world, {textured_.mesh.vertices[f[0]], textured_.mesh.vertices[f[1]],
                              textured_.mesh.vertices[f[2]]});
    const std::shared_ptr<const ColorImage> page = pages_.Page(textured_.page_idx[face]);
    const Eigen::Vector2f center = pages_.FilePixel(face, weights.tail<2>().cast<float>(), *page);
    return MeanAround(*page, center, texels_wide_[face]);
  }

 private:
  static Eigen::Vector3f MeanAround(const ColorImage& page, const Eigen::Vector2f& center,
                                    float width) {
    const int n = std::min(kMostSamples, static_cast<int>(std::ceil(width - 0.01f)));
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int i = 0; i < n * n; ++i) {
      const Eigen::Vector2f place(static_cast<float>(i % n), static_cast<float>(i / n));
      const Eigen::Vector2f offset = (place.array() + 0.5f) / static_cast<float>(n) - 0.5f;
      sum += SampleColor(page, center + width * offset);
    }
    return sum / static_cast<float>(n * n);
  }

  const TexturePages& pages_;
  const TexturedMesh& textured_;
  const MeshTracer& tracer_;
  const double reach_;
  std::vector<float> texels_wide_;  // #F: a new texel in old ones
};

}  // namespace

TransferredTexture TransferTexture(const TexturePages& pages, const MeshTracer& tracer,
                                   const TriangleMesh& mesh, double max_texels,
                                   const RunContext& context) {
  const TexturedMesh& textured = pages.textured();
  const double texel_size = std::max(
      {TexelSizeFor(mesh, max_texels), MeanTexelSize(textured.mesh, textured.texcoords), 1e-30});
  const SourceTexture source(pages, tracer, texel_size);
  BakedSurface baked = BakeSurface(
      mesh, texel_size,
      [&](const Eigen::Vector3d& x, const Eigen::Vector3d& normal) { return source.At(x, normal); },
      context);
  return {std::move(baked.texcoords), std::move(baked.page)};
}

}  // namespace lsmvs
