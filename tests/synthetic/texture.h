#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace lsmvs {

// What surfaces are painted with.
struct TextureOptions {
  double coarsest_wavelength = 0.5;  // world units
  double finest_wavelength = 0.01;   // world units; about 3 to 6 pixels shows and matches best
  double contrast = 1.0;             // scales the variation of the albedo
  double persistence = 0.8;    // amplitude of an octave relative to the one of twice its wavelength
  double weak_fraction = 0.0;  // share of space where the contrast is only weak_contrast
  double weak_contrast = 0.04;
  double weak_zone_size = 0.4;  // world units
  uint64_t seed = 1;
};

// Solid texture: colour as a band-limited function of the position in space (gradient noise,
// Perlin, SIGGRAPH 1985, summed over octaves), so that it needs no parametrisation and looks the
// same from every view. Immutable and thread-safe.
class SolidTexture {
 public:
  explicit SolidTexture(const TextureOptions& options);

  // Albedo in [0, 1]: red, green, blue. Octaves that are finer than about two `footprint`s (the
  // width of a pixel on the surface) fade out, as an ideal lens would average them.
  Eigen::Vector3f Albedo(const Eigen::Vector3d& x, double footprint) const;
  // 1 where the texture has full contrast, weak_contrast in the weak zones, smooth in between.
  double Strength(const Eigen::Vector3d& x) const;

 private:
  TextureOptions options_;
  double weak_threshold_;
};

// Gradient noise in about [-1, 1] with features of size 1; mean 0, twice differentiable.
double GradientNoise(const Eigen::Vector3d& x, uint64_t seed);

}  // namespace lsmvs
