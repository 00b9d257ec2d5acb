#pragma once

#include <array>
#include <span>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/stereo/patch_kernel.h"
#include "lsmvs/stereo/plane_map.h"

namespace lsmvs {

// The map of a source view that the geometric term compares with.
struct SourcePlanes {
  const PlaneMap* planes = nullptr;  // null: no geometric term for this view
  // Homogeneous map coordinates of reference coordinates (u, v) at inverse depth q are forward_m
  // (u, v, 1) + forward_e q, and back from map coordinates and inverse depth there. Both in image
  // coordinates (pixel centres at 0.5).
  float forward_m[9] = {}, forward_e[3] = {};
  float backward_m[9] = {}, backward_e[3] = {};
};

// What one level of one view is matched with.
struct MatchingProblem {
  const GrayImage* gray = nullptr;  // the reference
  std::vector<SourceView> sources;
  std::vector<SourcePlanes> source_planes;  // as many, or empty in the photometric pass
  WindowShape window;
  float noise_variance = 1;            // grey levels squared, at this level
  float geometric_weight = 0;          // cost a pixel of forward-backward error
  float geometric_max_px = 0;          // error is cut there
  std::vector<float> spatial_weights;  // a sample of the window
  std::vector<float> color_weights;    // by |grey difference| in steps of 1/kColorSteps
};
constexpr int kColorSteps = 2;

// Weights of the window's samples and of grey differences: Gaussians.
std::vector<float> SpatialWeights(const WindowShape& window, double sigma_px);
std::vector<float> ColorWeights(double sigma_gray);

struct PixelPosition {
  int column, row;
};
using PacketPixels = std::array<PixelPosition, kPacketSize>;

// Fills the reference side of a packet: bilateral weights, weighted greys, variances. Samples
// outside the image weigh 0.
void BuildPatch(const MatchingProblem& problem, const PacketPixels& pixels, PatchPacket* patch);

constexpr int kMaxSources = 16;
// Cost of a window that a source does not see: as bad as anticorrelation.
constexpr float kMaxCost = 2.0f;

// Costs of planes at 16 pixels over the sources `views` (positions in problem.sources).
class PacketScorer {
 public:
  PacketScorer(const MatchingProblem& problem, const PacketPixels& pixels);

  // ZNCC with one source.
  void Zncc(const PlanePacket& planes, int source, float* zncc) const;
  // Forward-backward error in reference pixels, cut at geometric_max_px; the cut value where the
  // map says nothing.
  void GeometricError(const PlanePacket& planes, int source, float* error_px) const;
  // 1 - ZNCC plus the geometric term, mean over the `num_best` cheapest of the sources.
  void Cost(const PlanePacket& planes, std::span<const uint8_t> views, int num_best,
            float* cost) const;
  const PatchPacket& patch() const { return patch_; }

 private:
  const MatchingProblem& problem_;
  PatchPacket patch_;
};

// How many of `num_views` sources are averaged: the others may be occluded.
inline int NumBestViews(int num_views) { return std::min(num_views, (num_views + 2) / 2); }

}  // namespace lsmvs
