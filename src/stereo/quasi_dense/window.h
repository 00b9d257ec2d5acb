#pragma once

#include "lsmvs/stereo/sampling/packed_image.h"

namespace lsmvs::quasi_dense {

// Largest window radius and the samples it takes at most.
inline constexpr int kMaxWindowRadius = 7;
inline constexpr int kMaxWindowSamples = 224;

// Where a window is sampled, relative to its centre, in pixels of the reference: all whole offsets
// up to `radius` but the four corners, with Gaussian weights (sigma = radius) that sum to 1. Padded
// to a multiple of 16 with weight 0.
struct WindowPattern {
  int radius = 0;
  int num_samples = 0;  // with padding
  alignas(64) float dx[kMaxWindowSamples] = {};
  alignas(64) float dy[kMaxWindowSamples] = {};
  alignas(64) float weight[kMaxWindowSamples] = {};
};
WindowPattern MakeWindowPattern(int radius);

// Where the pixels of a window lie in an image: offset (dx, dy) at (x + xx dx + xy dy, y + yx dx +
// yy dy).
struct WindowWarp {
  float x = 0, y = 0;  // image coordinates of the centre
  float xx = 1, xy = 0, yx = 0, yy = 1;
};

// The reference's side of ZNCC: weighted grey values, shifted and scaled so that their weighted
// mean is 0 and their weighted norm 1.
struct ReferenceWindow {
  float mean = 0, deviation = 0;  // grey levels
  alignas(64) float value[kMaxWindowSamples];
};

// Whether all samples of the warped window lie inside, where bilinear samples need no pixel beyond.
bool WindowInside(const PackedImage& image, const WindowPattern& pattern, const WindowWarp& warp);

// Reads the window; the caller has checked WindowInside. A window without texture gets deviation 0
// and values 0.
void ReadReferenceWindow(const PackedImage& image, const WindowPattern& pattern,
                         const WindowWarp& warp, ReferenceWindow* window);

// ZNCC in [-1, 1] of the warped window with the reference; 0 where the window is flat. The caller
// has checked WindowInside. Same value on every instruction set. About 1 ns a sample with AVX2.
float CompareWindow(const PackedImage& image, const WindowPattern& pattern, const WindowWarp& warp,
                    const ReferenceWindow& reference);

}  // namespace lsmvs::quasi_dense
