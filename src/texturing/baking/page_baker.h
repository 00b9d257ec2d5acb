#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/texturing/baking/seam_fades.h"
#include "lsmvs/texturing/charts/charts.h"
#include "lsmvs/texturing/labels/view_labels.h"
#include "lsmvs/texturing/levelling/label_nodes.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What the colour of a point of the surface is made of.
struct SurfaceAppearance {
  std::span<const int32_t> views;        // #F: the photo of each face, -1: none
  std::vector<Eigen::Vector3f> gains;    // #views
  LabelNodes nodes;                      // of `views`
  std::vector<Eigen::Vector3f> offsets;  // per node
  SeamFades fades;
  std::vector<Eigen::Vector3f> fill_colors;  // #V: of faces without a photo
};

// Colour and coverage of one page.
struct BakedPage {
  ColorImage colors;
  Raster<uint8_t> coverage;  // 0: nothing, 1: around a chart, 2: in a face
};

// Bakes a page: each texel takes the colour that the photo of its face has where it sees the point
// of the surface that the texel shows (bilinear), times the photo's gain, plus the levelling
// interpolated over the face, and mixed with the photos beyond the seam near one, with weights
// interpolated likewise. At a scale of 1 a
// texel of a face that faces the camera is a copied pixel. Around a chart go the faces that adjoin
// it, as far as the chart's photo shows them: what a viewer's filter reaches there is what the
// other chart shows. The rest of the page is filled by FillHoles. Photos are taken one after the
// other, each at most twice per page. 4 / 3 * 4 bytes per texel and 32 bytes per face of the page.
// Deterministic.
BakedPage BakePage(const Scene& scene, const ImageStore& images, const LabelEnergy& energy,
                   const SurfaceAppearance& appearance, const Charts& charts, int page_idx,
                   int page_side, const RunContext& context);

}  // namespace lsmvs
