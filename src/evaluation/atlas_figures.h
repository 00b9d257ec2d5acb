#pragma once

#include <cstddef>

#include "lsmvs/mesh/texture_pages.h"

namespace lsmvs {

// What a texture is like, without looking at photos.
struct AtlasFigures {
  size_t num_pages = 0;
  double num_texels = 0;  // of all pages
  int num_charts = 0;
  double utilisation = 0;  // share of the texels whose centre lies in a face
  size_t num_seam_samples = 0;
  // Mean difference of colours [grey levels] one texel to both sides of a seam, and of two points
  // two texels apart about 8 texels inside, at the same places; and the ratio of the two: 1 where
  // seams show no more than the texture itself.
  double seam_step = 0, inner_step = 0, seam_ratio = 0;
};

// Seams are the edges of the mesh over which the texture does not go on; they are sampled every 4
// texels. Deterministic. Holds one page with 4 bytes a texel besides those of `pages`.
AtlasFigures MeasureAtlas(const TexturePages& pages);

}  // namespace lsmvs
