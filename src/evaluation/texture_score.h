#pragma once

#include <array>
#include <string>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct TextureScoreOptions {
  // Level of the image pyramid: 0 full size, 1 half size.
  int level = 0;
  // Rays per pixel are the square of this.
  int antialiasing = 2;
  // Pixels at the mesh's silhouette that are not scored: there a photo mixes mesh and background.
  int margin = 2;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

struct TextureViewScore {
  std::string name;
  size_t num_pixels = 0;    // scored
  double completeness = 0;  // share of the photo's used pixels where the mesh is seen
  std::array<double, 3> gain = {1, 1, 1}, bias = {0, 0, 0};  // photo = gain * drawing + bias
  double psnr = 0;                                           // [dB], over all channels
  double ssim = 0;                                           // of grey values, windows of 7 x 7
  double one_minus_ncc = 0;  // mean over the same windows, of those with texture
};

struct TextureScore {
  std::vector<TextureViewScore> views;
  // Means over the views with scored pixels.
  size_t num_scored_views = 0;
  double completeness = 0, psnr = 0, ssim = 0, one_minus_ncc = 0;
};

// Draws the mesh from the photos' poses and compares with the photos, after fitting a gain and a
// bias per photo and channel: how good a texture (or vertex colours, where `texture` is null) is.
// Photos that the texture was not made from give the honest score. Two textures are compared on the
// same mesh: then the same pixels are scored. `view_idxs`: the views that are scored, all if empty.
// `tracer` is that of `mesh`. Deterministic. O(pixels * antialiasing^2 * log F).
//   M. Waechter, M. Beljan, S. Fuhrmann, N. Moehrle, J. Kopf, M. Goesele: Virtual rephotography:
//   novel view prediction error for 3D reconstruction, ACM Transactions on Graphics 36 (2017).
//   Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli: Image quality assessment: from error visibility to
//   structural similarity, IEEE Transactions on Image Processing 13 (2004).
TextureScore MeasureTextureScore(const MeshTracer& tracer, const TriangleMesh& mesh,
                                 const TexturePages* texture, const Scene& scene,
                                 const ImageStore& images, const std::vector<int>& view_idxs,
                                 const TextureScoreOptions& options, const RunContext& context);

}  // namespace lsmvs
