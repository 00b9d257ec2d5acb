#include "lsmvs/synthetic/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "lsmvs/synthetic/random.h"

namespace lsmvs {

namespace {

// Perlin's twelve gradients, four of them twice.
constexpr std::array<std::array<double, 3>, 16> kGradients = {{{1, 1, 0},
                                                               {-1, 1, 0},
                                                               {1, -1, 0},
                                                               {-1, -1, 0},
                                                               {1, 0, 1},
                                                               {-1, 0, 1},
                                                               {1, 0, -1},
                                                               {-1, 0, -1},
                                                               {0, 1, 1},
                                                               {0, -1, 1},
                                                               {0, 1, -1},
                                                               {0, -1, -1},
                                                               {1, 1, 0},
                                                               {0, -1, 1},
                                                               {-1, 1, 0},
                                                               {0, -1, -1}}};

double GradientTimes(uint32_t hash, double x, double y, double z) {
  const std::array<double, 3>& gradient = kGradients[hash & 15];
  return gradient[0] * x + gradient[1] * y + gradient[2] * z;
}

// Much faster than std::floor on a plain x86-64.
int64_t Floor(double x) {
  const auto truncated = static_cast<int64_t>(x);
  return truncated - (x < static_cast<double>(truncated));
}

uint32_t HashNode(uint32_t x, uint32_t y, uint32_t z, uint32_t seed) {
  uint32_t h = seed ^ (x * 0x8da6b343u) ^ (y * 0xd8163841u) ^ (z * 0xcb1ab31fu);
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

double Fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
double Mix(double a, double b, double t) { return a + t * (b - a); }

double SmoothStep(double begin, double end, double x) {
  const double t = std::clamp((x - begin) / (end - begin), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// What is left of a feature of `size` after averaging over a pixel of width `footprint`.
double PixelAttenuation(double size, double footprint) {
  if (footprint <= 0) return 1.0;
  const double phase = 0.5 * std::numbers::pi * footprint / size;
  return SmoothStep(1.0, 2.0, size / footprint) * std::sin(phase) / phase;
}

// Value below which the noise lies in this share of space.
double NoiseQuantile(double share) {
  constexpr int kNumSamples = 4000;
  std::vector<double> samples;
  for (int i = 0; i < kNumSamples; ++i) {
    Random random(99, static_cast<uint64_t>(i));
    const double x = random.Uniform(0, 1000), y = random.Uniform(0, 1000);
    samples.push_back(GradientNoise({x, y, random.Uniform(0, 1000)}, 7));
  }
  std::sort(samples.begin(), samples.end());
  return samples[static_cast<size_t>(share * (kNumSamples - 1))];
}

}  // namespace

double GradientNoise(const Eigen::Vector3d& x, uint64_t seed) {
  const int64_t cell_x = Floor(x[0]), cell_y = Floor(x[1]), cell_z = Floor(x[2]);
  const Eigen::Vector3d f(x[0] - static_cast<double>(cell_x), x[1] - static_cast<double>(cell_y),
                          x[2] - static_cast<double>(cell_z));
  const auto i = static_cast<uint32_t>(cell_x), j = static_cast<uint32_t>(cell_y);
  const auto k = static_cast<uint32_t>(cell_z), s = static_cast<uint32_t>(Random::Mix(seed));
  const auto corner = [&](uint32_t a, uint32_t b, uint32_t c) {
    return GradientTimes(HashNode(i + a, j + b, k + c, s), f[0] - a, f[1] - b, f[2] - c);
  };
  const double u = Fade(f[0]), v = Fade(f[1]), w = Fade(f[2]);
  const double bottom =
      Mix(Mix(corner(0, 0, 0), corner(1, 0, 0), u), Mix(corner(0, 1, 0), corner(1, 1, 0), u), v);
  const double top =
      Mix(Mix(corner(0, 0, 1), corner(1, 0, 1), u), Mix(corner(0, 1, 1), corner(1, 1, 1), u), v);
  return Mix(bottom, top, w);
}

SolidTexture::SolidTexture(const TextureOptions& options)
    : options_(options), weak_threshold_(NoiseQuantile(options.weak_fraction)) {}

double SolidTexture::Strength(const Eigen::Vector3d& x) const {
  if (options_.weak_fraction <= 0) return 1.0;
  const double noise = GradientNoise(x / options_.weak_zone_size, options_.seed + 1000);
  constexpr double kSoftness = 0.03;
  const double strong = SmoothStep(weak_threshold_ - kSoftness, weak_threshold_ + kSoftness, noise);
  return Mix(options_.weak_contrast, 1.0, strong);
}

Eigen::Vector3f SolidTexture::Albedo(const Eigen::Vector3d& x, double footprint) const {
  // Lightness has all octaves, the two directions of colour only coarse ones.
  constexpr int kMaxOctaves = 24;
  constexpr int kNumColorOctaves = 3;
  double light = 0, warm = 0, green = 0, amplitude = 1, sum_of_squares = 0;
  double size = options_.coarsest_wavelength;
  for (int octave = 0; octave < kMaxOctaves; ++octave) {
    if (size < 0.99 * options_.finest_wavelength) break;
    sum_of_squares += amplitude * amplitude;
    const double weight = amplitude * PixelAttenuation(size, footprint);
    // Each octave has its own place in the noise, so that no lattice point is common to all.
    const Eigen::Vector3d place = x / size + Eigen::Vector3d(17.3, 5.9, 31.7) * (octave + 1);
    const uint64_t seed = options_.seed + static_cast<uint64_t>(8 * octave);
    if (weight > 0) {
      light += weight * GradientNoise(place, seed);
      if (octave < kNumColorOctaves) {
        warm += weight * GradientNoise(place, seed + 1);
        green += weight * GradientNoise(place, seed + 2);
      }
    }
    amplitude *= options_.persistence;
    size *= 0.5;
  }
  const double scale = options_.contrast * Strength(x) / std::sqrt(sum_of_squares);
  // Gradient noise has a standard deviation of about 0.27; tanh keeps the albedo within (0, 1).
  const double value = 0.52 + 0.38 * std::tanh(2.5 * scale * light);
  const double red = value * (1 + 0.3 * scale * warm), blue = value * (0.9 - 0.3 * scale * warm);
  const Eigen::Vector3d albedo(red, value * (1 + 0.15 * scale * green), blue);
  return albedo.cwiseMax(0.0).cwiseMin(1.0).cast<float>();
}

}  // namespace lsmvs
