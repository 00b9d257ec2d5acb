#include "lsmvs/stereo/patch_match/level_matcher.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace lsmvs {

namespace {

// Offsets to pixels of the other colour, nearest first.
constexpr int kPropagationOffsets[LevelMatcher::kMaxPropagation][2] = {
    {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-3, 0}, {3, 0},
    {0, -3}, {0, 3}, {-7, 0}, {7, 0}, {0, -7}, {0, 7}};

// A parabola's step is damped as if its costs rose by so much towards both sides, for a window
// without texture: there the three costs differ by noise, and what coarser levels found is better.
constexpr float kStepDamping = 0.5f;

// Random planes turn away from the camera up to this cosine: ground before somebody who stands on
// it is seen at 10 to 20 degrees.
constexpr float kMinRandomCosine = 0.1f;

// ZNCC that is asked of a window which only one source sees: its 25 samples reach .5 by chance too
// often.
constexpr float kMinSingleZncc = 0.6f;

// Uniform in [-1, 1): a hash of its arguments.
float Noise(uint64_t salt, uint32_t pixel, uint32_t draw) {
  uint64_t h = salt + pixel * 0x9E3779B97F4A7C15ull + draw * 0xD1B54A32D192ED03ull;
  h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
  h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull;
  return static_cast<float>(static_cast<int32_t>(h >> 32)) * 0x1p-31f;
}

}  // namespace

struct LevelMatcher::Packet {
  Packet(const MatchingProblem& problem, const PacketPixels& at)
      : pixels(at), scorer(problem, at) {}
  PacketPixels pixels;
  MatchingCost scorer;
  std::array<bool, kPacketSize>
      inside{};  // lanes that are pixels of their own, not repeated at a border
  std::span<const uint8_t> views;
  size_t tile = 0;
  PlanePacket planes;
  alignas(64) float costs[kPacketSize];
  float step = 0;  // inverse depth that moves the pixels by one pixel in the sources
};

LevelMatcher::LevelMatcher(const MatchingProblem& problem, float min_inverse_depth,
                           float max_inverse_depth, uint64_t salt)
    : problem_(problem),
      min_q_(min_inverse_depth),
      max_q_(max_inverse_depth),
      salt_(salt),
      tiles_wide_((problem.gray->width + kTileWidth - 1) / kTileWidth),
      tiles_high_((problem.gray->height + kTileHeight - 1) / kTileHeight),
      costs_(problem.gray->width, problem.gray->height, 0.0f),
      tile_views_(static_cast<size_t>(tiles_wide_) * static_cast<size_t>(tiles_high_)) {}

size_t LevelMatcher::TileIndex(int tile_column, int tile_row) const {
  return static_cast<size_t>(tile_row) * static_cast<size_t>(tiles_wide_) +
         static_cast<size_t>(tile_column);
}

std::span<const uint8_t> LevelMatcher::ViewsAt(int column, int row) const {
  return std::span(tile_views_[TileIndex(column / kTileWidth, row / kTileHeight)])
      .first(static_cast<size_t>(num_tile_views_));
}

LevelMatcher::Packet LevelMatcher::Load(int tile_column, int tile_row, int color) const {
  PacketPixels pixels;
  std::array<bool, kPacketSize> inside;
  const int width = planes_.width, height = planes_.height;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    const int row = tile_row * kTileHeight + lane / 4;
    const int column = tile_column * kTileWidth + 2 * (lane % 4) + ((row & 1) ^ color);
    inside[lane] = column < width && row < height;
    pixels[lane] = {std::min(column, width - 1), std::min(row, height - 1)};
  }
  Packet packet(problem_, pixels);
  packet.inside = inside;
  packet.tile = TileIndex(tile_column, tile_row);
  packet.views = std::span(tile_views_[packet.tile]).first(static_cast<size_t>(num_tile_views_));
  for (int lane = 0; lane < kPacketSize; ++lane) {
    const Plane& plane = planes_(pixels[lane].column, pixels[lane].row);
    packet.planes.q[lane] = plane.q;
    packet.planes.qx[lane] = plane.qx;
    packet.planes.qy[lane] = plane.qy;
    packet.costs[lane] = costs_(pixels[lane].column, pixels[lane].row);
  }
  return packet;
}

void LevelMatcher::Store(const Packet& packet) {
  for (int lane = 0; lane < kPacketSize; ++lane) {
    if (!packet.inside[lane]) continue;
    const auto [column, row] = packet.pixels[lane];
    planes_(column, row) = {packet.planes.q[lane], packet.planes.qx[lane], packet.planes.qy[lane]};
    costs_(column, row) = packet.costs[lane];
  }
}

template <class Body>
void LevelMatcher::ForEachPacket(const RunContext& context, int color, const Body& body) {
  ParallelFor(context, static_cast<size_t>(tiles_high_), 1, [&](size_t tile_row) {
    for (int tile_column = 0; tile_column < tiles_wide_; ++tile_column) {
      Packet packet = Load(tile_column, static_cast<int>(tile_row), color);
      body(&packet);
      Store(packet);
    }
  });
}

void LevelMatcher::Try(const PlanePacket& candidate, Packet* packet) const {
  alignas(64) float costs[kPacketSize];
  packet->scorer.Cost(candidate, packet->views, costs);
  PlanePacket& planes = packet->planes;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    const bool better = costs[lane] < packet->costs[lane] && candidate.q[lane] >= min_q_ &&
                        candidate.q[lane] <= max_q_;
    packet->costs[lane] = better ? costs[lane] : packet->costs[lane];
    planes.q[lane] = better ? candidate.q[lane] : planes.q[lane];
    planes.qx[lane] = better ? candidate.qx[lane] : planes.qx[lane];
    planes.qy[lane] = better ? candidate.qy[lane] : planes.qy[lane];
  }
}

void LevelMatcher::Propagate(int count, Packet* packet) const {
  PlanePacket candidate;
  for (int i = 0; i < std::min(count, kMaxPropagation); ++i) {
    const int dx = kPropagationOffsets[i][0], dy = kPropagationOffsets[i][1];
    for (int lane = 0; lane < kPacketSize; ++lane) {
      const auto [column, row] = packet->pixels[lane];
      Plane plane{packet->planes.q[lane], packet->planes.qx[lane], packet->planes.qy[lane]};
      if (planes_.Inside(column + dx, row + dy)) {
        plane =
            planes_(column + dx, row + dy).Moved(static_cast<float>(-dx), static_cast<float>(-dy));
      }
      candidate.q[lane] = plane.q;
      candidate.qx[lane] = plane.qx;
      candidate.qy[lane] = plane.qy;
    }
    Try(candidate, packet);
  }
}

float LevelMatcher::InverseDepthStep(const Packet& packet) const {
  const float u = packet.scorer.patch().u[5], v = packet.scorer.patch().v[5];
  float mean_q = 0;
  for (const float q : packet.planes.q) mean_q += q / kPacketSize;
  float displacement = 0;
  for (const uint8_t source : packet.views) {
    const SourceView& view = problem_.sources[source];
    const float* m = view.m;
    const float* e = view.e;
    const float w = m[6] * u + m[7] * v + m[8] + e[2] * mean_q;
    const float x = (m[0] * u + m[1] * v + m[2] + e[0] * mean_q) / w;
    const float y = (m[3] * u + m[4] * v + m[5] + e[1] * mean_q) / w;
    displacement += std::hypot(e[0] - x * e[2], e[1] - y * e[2]) / std::abs(w);
  }
  return static_cast<float>(packet.views.size()) / std::max(displacement, 1e-20f);
}

void LevelMatcher::Perturb(const SweepSettings& settings, Packet* packet) const {
  PlanePacket candidate;
  const int num_trials = settings.num_random + settings.num_perturbed + settings.num_steep;
  for (int trial = 0; trial < num_trials; ++trial) {
    const bool anywhere = trial < settings.num_random;
    const bool steep = trial >= settings.num_random + settings.num_perturbed;
    const float slope = (steep ? settings.steep_slope : settings.slope) * packet->step;
    for (int lane = 0; lane < kPacketSize; ++lane) {
      const auto [column, row] = packet->pixels[lane];
      const uint32_t pixel = static_cast<uint32_t>(planes_.Index(column, row));
      const auto noise = [&](int draw) {
        return Noise(
            salt_, pixel,
            (sweep_ * 64 + static_cast<uint32_t>(trial)) * 4 + static_cast<uint32_t>(draw));
      };
      const std::array<float, 3> draws = {noise(0), noise(1), noise(2)};
      const Plane plane =
          anywhere ? RandomPlane(packet->pixels[lane], draws)
                   : Plane{packet->planes.q[lane] + settings.depth_px * packet->step * draws[0],
                           packet->planes.qx[lane] + slope * draws[1],
                           packet->planes.qy[lane] + slope * draws[2]};
      candidate.q[lane] = plane.q;
      candidate.qx[lane] = plane.qx;
      candidate.qy[lane] = plane.qy;
    }
    Try(candidate, packet);
  }
}

Plane LevelMatcher::RandomPlane(const PixelPosition& pixel,
                                const std::array<float, 3>& draws) const {
  const float depth_draw = 0.5f + 0.5f * draws[0], turn = std::numbers::pi_v<float> * draws[1];
  const float cosine = 1 - (1 - kMinRandomCosine) * (0.5f + 0.5f * draws[2]);
  const float sine = std::sqrt(1 - cosine * cosine);
  const Eigen::Vector3f ray = problem_.camera.PixelRay(pixel.column, pixel.row).cast<float>();
  const Eigen::Vector3f back = -ray.normalized();
  const Eigen::Vector3f across = back.cross(Eigen::Vector3f::UnitY()).normalized();
  const Eigen::Vector3f normal =
      cosine * back + sine * (std::cos(turn) * across + std::sin(turn) * across.cross(back));
  const float q = min_q_ + depth_draw * (max_q_ - min_q_);
  const float along = q / normal.dot(ray);
  return {q, along * normal.x() / static_cast<float>(problem_.camera.fx),
          along * normal.y() / static_cast<float>(problem_.camera.fy)};
}

// Minimum of the parabola through three costs, in steps, with `damping` added to both outer ones; 0
// where they are not convex.
float ParabolaMinimum(float before, float at, float after, float damping) {
  const float curvature = before + after - 2 * (at - damping);
  return curvature > 1e-6f ? std::clamp(0.5f * (before - after) / curvature, -1.0f, 1.0f) : 0.0f;
}

void LevelMatcher::RefineByParabola(float (PlanePacket::*field)[kPacketSize], float step,
                                    Packet* packet) const {
  alignas(64) float after[kPacketSize], before[kPacketSize];
  PlanePacket candidate = packet->planes;
  for (float& value : candidate.*field) value += step;
  packet->scorer.Cost(candidate, packet->views, after);
  for (float& value : candidate.*field) value -= 2 * step;
  packet->scorer.Cost(candidate, packet->views, before);
  const float noise = problem_.noise_variance;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    const float damping = kStepDamping * noise / (packet->scorer.patch().variance[lane] + noise);
    (candidate.*field)[lane] =
        (packet->planes.*field)[lane] +
        step * ParabolaMinimum(before[lane], packet->costs[lane], after[lane], damping);
  }
  Try(candidate, packet);
}

void LevelMatcher::ChooseViews(int num_views, Packet* packet) {
  const int num_sources = static_cast<int>(problem_.sources.size());
  std::array<float, kMaxSources> support{};
  alignas(64) float zncc[kPacketSize];
  for (int source = 0; source < num_sources; ++source) {
    packet->scorer.Zncc(packet->planes, source, zncc);
    for (const float value : zncc) support[source] += std::max(value, 0.0f);
  }
  std::array<uint8_t, kMaxSources> order{};
  std::iota(order.begin(), order.begin() + num_sources, uint8_t{0});
  std::stable_sort(order.begin(), order.begin() + num_sources,
                   [&](uint8_t a, uint8_t b) { return support[a] > support[b]; });
  // Stable only because GCC 14 warns of std::sort here, wrongly.
  std::stable_sort(order.begin(), order.begin() + num_views);
  tile_views_[packet->tile] = order;
}

void LevelMatcher::Start(PlaneMap planes, int num_views, const RunContext& context) {
  planes_ = std::move(planes);
  num_tile_views_ = std::min(num_views, static_cast<int>(problem_.sources.size()));
  const float spread = max_q_ - min_q_;
  for (size_t i = 0; i < planes_.size(); ++i) {
    Plane& plane = planes_.pixels[i];
    if (plane.q > 0) {
      plane.q = std::clamp(plane.q, min_q_, max_q_);
      continue;
    }
    plane = {min_q_ + spread * (0.5f + 0.5f * Noise(salt_, static_cast<uint32_t>(i), 1)), 0, 0};
  }
  for (const int color : {0, 1}) {
    ForEachPacket(context, color, [&](Packet* packet) {
      if (color == 0) ChooseViews(num_tile_views_, packet);
      packet->views =
          std::span(tile_views_[packet->tile]).first(static_cast<size_t>(num_tile_views_));
      packet->scorer.Cost(packet->planes, packet->views, packet->costs);
    });
  }
  ++sweep_;
}

void LevelMatcher::InheritNeighbors(const PlaneMap& coarse, const RunContext& context) {
  const float scale_x = static_cast<float>(coarse.width) / static_cast<float>(planes_.width);
  const float scale_y = static_cast<float>(coarse.height) / static_cast<float>(planes_.height);
  const auto inherit = [&](const PixelPosition& pixel, bool across, bool down) -> Plane {
    const float x = (static_cast<float>(pixel.column) + 0.5f) * scale_x;
    const float y = (static_cast<float>(pixel.row) + 0.5f) * scale_y;
    int column = static_cast<int>(x), row = static_cast<int>(y);
    if (across) column += x - static_cast<float>(column) < 0.5f ? -1 : 1;
    if (down) row += y - static_cast<float>(row) < 0.5f ? -1 : 1;
    column = std::clamp(column, 0, coarse.width - 1);
    row = std::clamp(row, 0, coarse.height - 1);
    Plane plane =
        coarse(column, row)
            .Moved(x - (static_cast<float>(column) + 0.5f), y - (static_cast<float>(row) + 0.5f));
    plane.qx *= scale_x;
    plane.qy *= scale_y;
    return plane;
  };
  for (const int color : {0, 1}) {
    ForEachPacket(context, color, [&](Packet* packet) {
      PlanePacket candidate;
      for (int i = 1; i < 4; ++i) {
        for (int lane = 0; lane < kPacketSize; ++lane) {
          const Plane plane = inherit(packet->pixels[lane], i & 1, i & 2);
          candidate.q[lane] = plane.q;
          candidate.qx[lane] = plane.qx;
          candidate.qy[lane] = plane.qy;
        }
        Try(candidate, packet);
      }
    });
  }
}

void LevelMatcher::Sweep(const SweepSettings& settings, const RunContext& context) {
  for (const int color : {0, 1}) {
    ForEachPacket(context, color, [&](Packet* packet) {
      packet->step = InverseDepthStep(*packet);
      Propagate(settings.num_propagated, packet);
      Perturb(settings, packet);
      if (settings.parabola_px > 0)
        RefineByParabola(&PlanePacket::q, settings.parabola_px * packet->step, packet);
      if (settings.parabola_slope > 0) {
        RefineByParabola(&PlanePacket::qx, settings.parabola_slope * packet->step, packet);
        RefineByParabola(&PlanePacket::qy, settings.parabola_slope * packet->step, packet);
      }
    });
  }
  ++sweep_;
}

void LevelMatcher::Filter(const FilterSettings& settings, const RunContext& context) {
  const bool geometric = !problem_.source_planes.empty() && settings.min_num_consistent > 0;
  const int num_sources = static_cast<int>(problem_.sources.size());
  const auto filter = [&](Packet* packet) {
    alignas(64) float value[kPacketSize];
    std::array<float, kPacketSize> best, second;
    best.fill(kInvalidZncc);
    second.fill(kInvalidZncc);
    for (const uint8_t source : packet->views) {
      packet->scorer.Zncc(packet->planes, source, value);
      for (int lane = 0; lane < kPacketSize; ++lane) {
        second[lane] = std::max(second[lane], std::min(best[lane], value[lane]));
        best[lane] = std::max(best[lane], value[lane]);
      }
    }
    std::array<int, kPacketSize> num_consistent{};
    for (int source = 0; geometric && source < num_sources; ++source) {
      packet->scorer.GeometricError(packet->planes, source, value);
      for (int lane = 0; lane < kPacketSize; ++lane) {
        num_consistent[lane] += value[lane] <= settings.max_error_px;
      }
    }
    for (int lane = 0; lane < kPacketSize; ++lane) {
      // A window that one source alone sees must match it well.
      const bool several = second[lane] > kInvalidZncc;
      const float zncc = several ? 0.5f * (best[lane] + second[lane]) : best[lane];
      const float min_zncc =
          several ? settings.min_zncc : std::max(settings.min_zncc, kMinSingleZncc);
      const float texture = packet->scorer.patch().variance[lane];
      const float needed = min_zncc * texture / (texture + problem_.noise_variance);
      const bool keep =
          zncc >= needed && (!geometric || num_consistent[lane] >= settings.min_num_consistent);
      if (!keep) packet->planes.q[lane] = 0;
    }
  };
  for (const int color : {0, 1}) ForEachPacket(context, color, filter);
}

}  // namespace lsmvs
