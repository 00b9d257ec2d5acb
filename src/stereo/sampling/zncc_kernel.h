#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/stereo/sampling/packed_image.h"

namespace lsmvs {

// The inner loop of PatchMatch: ZNCC of 16 reference windows at once ("a packet") against one
// source view, each window warped by its own plane. Lanes are pixels, so that warps and sums are
// vectorised as well as samples.

constexpr int kPacketSize = 16;
constexpr int kMaxWindowSide = 15;  // samples along a side of a window
constexpr int kMaxWindowSamples = kMaxWindowSide * kMaxWindowSide;

// What stays the same for every plane and every view tried on 16 pixels.
struct alignas(64) PatchPacket {
  float u[kPacketSize], v[kPacketSize];  // image coordinates of the pixels' centres
  float stretch[kPacketSize];  // per lane: the window's samples lie so many times as far apart
  // Per lane the weighted variance of the window, grey levels squared; weights sum to 1.
  float variance[kPacketSize];
  float weight[kMaxWindowSamples][kPacketSize];
  float weighted_gray[kMaxWindowSamples][kPacketSize];  // weight * (grey - weighted mean)
};

struct alignas(64) PlanePacket {
  float q[kPacketSize], qx[kPacketSize], qy[kPacketSize];  // see Plane
};

// The samples of a window: offsets step * {-half..half} in both directions, row by row.
struct WindowShape {
  int half = 2;
  int step = 2;
  int Side() const { return 2 * half + 1; }
  int NumSamples() const { return Side() * Side(); }
};

// What the samples of a window weigh.
struct PatchWeights {
  PatchWeights() = default;
  // Gaussians over the distance from the centre (pixels) and the difference from its grey value
  // (0-255).
  PatchWeights(const WindowShape& shape, double sigma_px, double sigma_gray);

  WindowShape window;
  // Windows of less variance (grey levels squared) are stretched to twice the size, with as many
  // samples: where there is little texture, more of it comes in.
  float min_variance = 0;
  std::vector<float> spatial;  // a sample
  std::vector<float> color;    // by |grey difference| in steps of 1/kColorSteps
};
constexpr int kColorSteps = 2;

struct PixelPosition {
  int column, row;
};
using PacketPixels = std::array<PixelPosition, kPacketSize>;

// Fills a packet: stretch, bilateral weights, weighted greys, variances. Samples outside the image
// weigh 0.
void BuildPatch(const GrayImage& gray, const PatchWeights& weights, const PacketPixels& pixels,
                PatchPacket* patch);

// Maps reference pixels to a source image: homogeneous source coordinates of reference image
// coordinates (u, v) at inverse depth q are M (u, v, 1) + e q. Source coordinates count from the
// centre of the first pixel.
struct SourceView {
  const PackedImage* image = nullptr;
  float m[9] = {};  // row by row
  float e[3] = {};
};

// Value for a window that does not lie inside the source image.
constexpr float kInvalidZncc = -2.0f;

// zncc[lane] in [-1, 1], or kInvalidZncc. Both variances are raised by `noise_variance` (grey
// levels squared), which brings windows without texture to 0 instead of to chance. The perspective
// division over a window is expanded to second order around its centre (error below 1e-3 px).
void ScorePacket(const PatchPacket& patch, const WindowShape& window, const PlanePacket& planes,
                 const SourceView& source, float noise_variance, float* zncc);

// Name of the instruction set that ScorePacket runs on here.
const char* ScorePacketTarget();

}  // namespace lsmvs
