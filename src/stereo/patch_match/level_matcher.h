#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/stereo/patch_match/matching_cost.h"
#include "lsmvs/stereo/sampling/plane_map.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// One sweep over all pixels of a level.
struct SweepSettings {
  // Planes of so many neighbours are tried: the nearest first, at most kMaxPropagation.
  int num_propagated = 4;
  // Random trials: planes perturbed by up to `depth_px` of displacement in the sources and `slope`
  // in its gradient; num_steep more by up to `steep_slope`.
  int num_perturbed = 0, num_steep = 0;
  float depth_px = 1.0f;
  float slope = 0.1f, steep_slope = 0;
  // Trials drawn from the whole range of depth.
  int num_random = 0;
  // Minimum of the parabola through the costs at +-parabola_px of displacement. 0: none.
  float parabola_px = 0;
  // The same for the slopes, in displacement per pixel.
  float parabola_slope = 0;
};

// PatchMatch on one pyramid level of one view. Pixels are treated in packets of 16: the pixels of
// one colour of a checkerboard within a tile of 8 x 4. A sweep updates all red packets, then all
// black ones, each from the other colour only; packets of a colour are independent, so that threads
// cannot change the result.
class LevelMatcher {
 public:
  static constexpr int kTileWidth = 8, kTileHeight = 4;
  static constexpr int kMaxPropagation = 12;

  // `problem` must outlive the matcher. `inverse_depth_*` bound every plane tried.
  LevelMatcher(const MatchingProblem& problem, float min_inverse_depth, float max_inverse_depth,
               uint64_t salt);

  // Starts from given planes (of the level's size). Pixels without one get a random plane. Each
  // tile keeps the `num_views` sources that match best.
  void Start(PlaneMap planes, int num_views, const RunContext& context);
  // Tries for each pixel the planes of the nearest pixels of a coarser map.
  void InheritNeighbors(const PlaneMap& coarse, const RunContext& context);
  void Sweep(const SweepSettings& settings, const RunContext& context);

  // Sets q to 0 where the windows' ZNCC (mean over the best half of the tile's sources) is below
  // `min_zncc`, or where fewer than `min_num_consistent` sources agree within `max_error_px` forth
  // and back (geometric pass only).
  struct FilterSettings {
    float min_zncc = 0.1f;
    int min_num_consistent = 0;
    float max_error_px = 1.0f;
  };
  void Filter(const FilterSettings& settings, const RunContext& context);

  const PlaneMap& planes() const { return planes_; }
  const Raster<float>& costs() const { return costs_; }
  // Sources that the tile of a pixel uses.
  std::span<const uint8_t> ViewsAt(int column, int row) const;

 private:
  struct Packet;
  template <class Body>
  void ForEachPacket(const RunContext& context, int color, const Body& body);
  Packet Load(int tile_column, int tile_row, int color) const;
  void Store(const Packet& packet);
  void Try(const PlanePacket& candidate, Packet* packet) const;
  void Propagate(int count, Packet* packet) const;
  void Perturb(const SweepSettings& settings, Packet* packet) const;
  // Any depth of the range, any normal that the camera sees; `draws` in [-1, 1).
  Plane RandomPlane(const PixelPosition& pixel, const std::array<float, 3>& draws) const;
  void RefineByParabola(float (PlanePacket::*field)[kPacketSize], float step, Packet* packet) const;
  void ChooseViews(int num_views, Packet* packet);
  float InverseDepthStep(const Packet& packet) const;
  size_t TileIndex(int tile_column, int tile_row) const;

  const MatchingProblem& problem_;
  float min_q_, max_q_;
  uint64_t salt_;
  uint32_t sweep_ = 0;
  int tiles_wide_, tiles_high_;
  PlaneMap planes_;
  Raster<float> costs_;
  std::vector<std::array<uint8_t, kMaxSources>> tile_views_;
  int num_tile_views_ = 0;
};

}  // namespace lsmvs
