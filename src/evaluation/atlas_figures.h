#pragma once

#include <cstddef>

#include "lsmvs/evaluation/seam_photos.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What a texture is like, without looking at photos.
struct AtlasFigures {
  size_t num_pages = 0;
  double num_texels = 0;  // of all pages
  int num_charts = 0;
  double utilisation = 0;  // share of the texels whose centre lies in a face
  // Seams are sampled where the texel next to them lies in its chart on both sides and, with
  // photos, where one photo sees both sides.
  size_t num_seam_samples = 0;
  // Mean difference of colours [grey levels] one texel to both sides of a seam, and of two points
  // two texels apart about 8 texels inside, at the same places; and the ratio of the two. It is 1
  // for seams that do not show on an even surface; creases, where seams like to lie, raise it.
  double seam_step = 0, inner_step = 0, seam_ratio = 0;
  // With photos: mean difference that a single photo shows between the same two points of the
  // surface, and seam_step by it: 1 where seams show no more than the surface itself.
  double photo_step = 0, photo_ratio = 0;
};

// Seams are the edges of the mesh over which the texture does not go on; they are sampled every 4
// texels. `photos`: null to do without. Deterministic. Holds one page with 4 bytes per texel
// besides those of `pages`, and one photo.
AtlasFigures MeasureAtlas(const TexturePages& pages, const SeamPhotos* photos,
                          const RunContext& context);

}  // namespace lsmvs
