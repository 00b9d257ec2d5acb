#pragma once

#include <array>
#include <span>
#include <vector>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/stereo/patch_match/consistency_kernel.h"
#include "lsmvs/stereo/sampling/plane_map.h"
#include "lsmvs/stereo/sampling/zncc_kernel.h"

namespace lsmvs {

// What one level of one view is matched with.
struct MatchingProblem {
  const GrayImage* gray = nullptr;  // the reference
  PinholeCamera camera;             // its camera, of the same size
  std::vector<SourceView> sources;
  std::vector<SourcePlanes> source_planes;  // as many, or empty in the photometric pass
  PatchWeights weights;
  float noise_variance = 1;    // grey levels squared, at this level
  float geometric_weight = 0;  // cost a pixel of forward-backward error
  float geometric_max_px = 0;  // error is cut there
};

constexpr int kMaxSources = 16;
// 1 - ZNCC is cut here: anticorrelated is no worse than uncorrelated. Also the cost of a plane that
// puts the window outside all sources.
constexpr float kMaxPhotometricCost = 1.2f;

// Costs of planes at 16 pixels over the sources `views` (positions in problem.sources).
class MatchingCost {
 public:
  MatchingCost(const MatchingProblem& problem, const PacketPixels& pixels);

  // ZNCC with one source.
  void Zncc(const PlanePacket& planes, int source, float* zncc) const;
  // Forward-backward error in reference pixels, cut at geometric_max_px; the cut value where the
  // map says nothing.
  void GeometricError(const PlanePacket& planes, int source, float* error_px) const;
  // 1 - ZNCC plus the geometric term, mean over the two cheapest of the sources; one that is
  // .2 worse than the best or more counts as .2 worse: it may not see the surface. Where fewer see
  // the window, the missing ones count as those that do, if a little pessimistically: a pixel at
  // the border of the scene that two views see is matched with two.
  void Cost(const PlanePacket& planes, std::span<const uint8_t> views, float* cost) const;
  const PatchPacket& patch() const { return patch_; }

 private:
  const MatchingProblem& problem_;
  PatchPacket patch_;
};

}  // namespace lsmvs
