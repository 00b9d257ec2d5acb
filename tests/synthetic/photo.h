#pragma once

#include <cstdint>
#include <string>

#include "lsmvs/image/raster.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/synthetic/shape.h"
#include "lsmvs/synthetic/texture.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct PhotoOptions {
  TextureOptions texture;
  Eigen::Vector3d light = {0.3, -0.5, 0.8};  // direction to the light; any length but 0
  double ambient = 0.45;      // share of the light that comes from everywhere; 1: no shading
  bool cast_shadows = false;  // whether the light is blocked by the shape
  double gain_sigma =
      0.0;  // every image is multiplied by 1 + a Gaussian of this standard deviation
  double offset_sigma = 0.0;   // and a Gaussian is added, grey levels
  double noise_sigma = 0.0;    // sensor noise a pixel and channel, grey levels
  double exposure_step = 1.0;  // every second view is multiplied by this
  double moving_shadow = 0.0;  // 0: none; else the share of light that a band takes away which lies
                               // elsewhere in each view
  double specular = 0.0;       // strength of a highlight (Blinn-Phong), share of full white
  double specular_exponent = 60.0;
  int supersampling = 3;  // rays per side of a pixel where depth or normal jumps; 1: none
  Color background = Color(90, 110, 140);
  uint64_t seed = 0;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Renders the photo that a view takes of the shape. Pixels are integrals over their squares
// (texture faded by footprint, edges supersampled). Same bytes for any number of threads. About 1
// microsecond a pixel and core for simple shapes.
ColorImage RenderPhoto(const Shape& shape, const Scene& scene, int view_idx,
                       const PhotoOptions& options, const RunContext& context);

// Writes the photos of all views to `folder` (made if missing) under the views' names and
// sets scene->image_folder.
void WritePhotos(const Shape& shape, const PhotoOptions& options, const std::string& folder,
                 Scene* scene, const RunContext& context);

// As PNG or, with any other extension, JPEG of quality 95.
void WriteImage(const std::string& path, const ColorImage& image);

}  // namespace lsmvs
