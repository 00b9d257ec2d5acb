#pragma once

#include <cstdint>
#include <string>

#include "lsmvs/scene/scene.h"
#include "lsmvs/synthetic/named_shapes.h"
#include "lsmvs/synthetic/photo.h"
#include "lsmvs/synthetic/shape.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

// Where the cameras stand.
enum class CameraLayout {
  kAuto,  // what suits the shape: rings around objects, an arc before walls, a grid above terrain
  kRing,  // two rings around the shape, the upper one looking down at 45 degrees
  kArc,   // a quarter circle at two heights before the -y side
  kGrid,  // a grid above, looking down, every second row tilted by 15 degrees
};

struct SyntheticSceneOptions {
  ShapeName shape = ShapeName::kSphere;
  CameraLayout layout = CameraLayout::kAuto;
  int num_views = 12;
  int width = 320, height = 240;  // pixels
  double focal_factor = 1.2;      // focal length / longer side
  int num_sparse_points = 2000;   // with tracks, for view selection; 0: none
  double sparse_noise_px = 0.0;   // standard deviation of the sparse points, pixels on the surface
  std::string image_extension = "png";  // or "jpg": of the views' names
  uint64_t seed = 0;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// A scene with exact truth.
struct SyntheticScene {
  ShapePtr shape;
  Scene scene;     // views and sparse points; image_folder is empty until WritePhotos
  double gsd = 0;  // one pixel on the surface, median over the surface and the views that see it
  PhotoOptions photo;  // texture with wavelengths that suit the gsd, no noise
};

// A town has the size that the photos of a flight cover: strips, of which photos overlap by 3/4
// along and 2/3 across, and every second photo looks 25 degrees aside; `layout` says nothing there.
SyntheticScene MakeScene(const SyntheticSceneOptions& options, const RunContext& context);

// Shorthand for tests.
SyntheticScene MakeScene(ShapeName shape, int num_views, int width, int height);

}  // namespace lsmvs
