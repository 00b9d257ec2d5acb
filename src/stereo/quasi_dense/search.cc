#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "lsmvs/stereo/quasi_dense/planes.h"
#include "lsmvs/stereo/quasi_dense/search.h"
#include "lsmvs/util/check.h"

namespace lsmvs::quasi_dense {

namespace {

constexpr size_t kRowsOfBlock = 4;
constexpr int kMaxSweepSteps = 1024;
constexpr int kMaxClimb = 3;
constexpr int kFitReach = 2;
// Error of a match in pixels of parallax, for plane fits.
constexpr float kMatchErrorPx = 0.4f;
constexpr float kRefineStepPx = 0.7f;

// Position of the maximum of the parabola through (-1, left), (0, middle), (1, right).
float ParabolaMaximum(float left, float middle, float right) {
  const float curvature = left - 2 * middle + right;
  if (!(curvature < -1e-6f)) return 0;
  return std::clamp(0.5f * (left - right) / curvature, -0.5f, 0.5f);
}

}  // namespace

PointSearch::PointSearch(const SearchView& view, const Eigen::Vector2f& position)
    : view_(view), position_(position) {
  WindowWarp warp;
  warp.x = position.x();
  warp.y = position.y();
  if (WindowInside(*view.image, view.pattern, warp)) {
    ReadReferenceWindow(*view.image, view.pattern, warp, &reference_);
  } else {
    reference_.deviation = 0;
  }
}

void PointSearch::UseSlots(uint32_t mask, int max_count) {
  constexpr int kMinCount = 2;
  const int num_slots = static_cast<int>(view_.pairings.size());
  num_in_use_ = 0;
  for (int s = 0; s < num_slots && num_in_use_ < max_count; ++s) {
    if ((mask >> s & 1u) != 0) in_use_[num_in_use_++] = s;
  }
  for (int s = 0; s < num_slots && num_in_use_ < std::min(kMinCount, max_count); ++s) {
    if ((mask >> s & 1u) == 0) in_use_[num_in_use_++] = s;
  }
}

PointSearch::Outcome PointSearch::Compare(const Plane& plane) {
  std::array<float, kNumBest> best{};  // descending
  Outcome outcome;
  for (int k = 0; k < num_in_use_; ++k) {
    const int slot = in_use_[k];
    PlaneWarp warped;
    if (!WarpPlane(view_.pairings[slot].there, position_, plane, &warped)) continue;
    const PackedImage& other = *view_.others[slot];
    if (!WindowInside(other, view_.pattern, warped.warp)) continue;
    float ncc = CompareWindow(other, view_.pattern, warped.warp, reference_);
    ++num_patches_;
    if (ncc >= view_.min_ncc) outcome.slots |= 1u << slot;
    for (float& kept : best) {
      if (ncc > kept) std::swap(ncc, kept);
    }
  }
  float total = 0;
  for (const float ncc : best) total += ncc;
  outcome.score = total / static_cast<float>(std::clamp(num_in_use_, 1, kNumBest));
  return outcome;
}

void PointSearch::Try(const Plane& plane) {
  if (!(plane.q >= view_.min_inverse_depth && plane.q <= view_.max_inverse_depth)) {
    return;
  }
  if (num_tried_ < kMaxTried) tried_[num_tried_++] = plane.q;
  const Outcome outcome = Compare(plane);
  if (outcome.score <= score_) return;
  best_ = plane;
  score_ = outcome.score;
  slots_ = outcome.slots;
}

bool PointSearch::Tried(float inverse_depth) const {
  if (num_tried_ == 0) return false;
  const float near = 0.5f * StepAt(inverse_depth);
  return std::any_of(tried_, tried_ + num_tried_,
                     [&](float tried) { return std::abs(tried - inverse_depth) < near; });
}

float PointSearch::StepAt(float inverse_depth) const {
  float total = 0;
  int count = 0;
  for (int k = 0; k < num_in_use_; ++k) {
    PlaneWarp warped;
    const Plane plane{inverse_depth, 0, 0};
    if (!WarpPlane(view_.pairings[in_use_[k]].there, position_, plane, &warped)) continue;
    total += warped.velocity.norm();
    ++count;
  }
  return total > 0 ? static_cast<float>(count) / total : 0;
}

void PointSearch::Sweep() {
  const float middle = 0.5f * (view_.min_inverse_depth + view_.max_inverse_depth);
  const float range = view_.max_inverse_depth - view_.min_inverse_depth;
  const float step = StepAt(middle);
  if (!(step > 0)) return;
  const int num_steps = static_cast<int>(std::clamp(range / step, 1.0f, float{kMaxSweepSteps}));
  for (int k = 0; k <= num_steps; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(num_steps);
    Try({view_.min_inverse_depth + t * range, 0, 0});
  }
}

void PointSearch::Refine(float step_px) {
  if (!found()) return;
  const float step = step_px * StepAt(best_.q);
  if (!(step > 0)) return;
  const auto score_at = [&](float offset) {
    Plane plane = best_;
    plane.q += offset;
    return plane.known() ? Compare(plane).score : -2.0f;
  };
  float left = score_at(-step), right = score_at(step);
  for (int climb = 0; climb < kMaxClimb && std::max(left, right) > score_; ++climb) {
    const bool to_right = right > left;
    const float middle = score_;
    best_.q += to_right ? step : -step;
    score_ = to_right ? right : left;
    const float next = score_at(to_right ? step : -step);
    left = to_right ? middle : next;
    right = to_right ? next : middle;
  }
  best_.q += step * ParabolaMaximum(left, score_, right);
  const Outcome outcome = Compare(best_);
  score_ = outcome.score;
  slots_ = outcome.slots;
}

namespace {

void StoreMatch(const SearchView& view, const PointSearch& search, InterestPoint* point) {
  const bool matched = search.found() && search.score() >= view.min_ncc && search.slots() != 0;
  point->plane = matched ? search.best() : Plane();
  point->score = matched ? search.score() : 0;
  point->slots = matched ? search.slots() : 0;
}

// Calls match(point) -> windows compared for each point that exists; adds those up.
template <class Match>
size_t ForPoints(const RunContext& context, PointGrid* grid, const Match& match) {
  const size_t num_rows = static_cast<size_t>(grid->cells.height);
  std::vector<size_t> num_patches((num_rows + kRowsOfBlock - 1) / kRowsOfBlock, 0);
  ParallelBlocks(context, num_rows, kRowsOfBlock, [&](size_t begin, size_t end) {
    size_t count = 0;
    for (size_t row = begin; row < end; ++row) {
      for (int column = 0; column < grid->cells.width; ++column) {
        InterestPoint& point = grid->cells(column, static_cast<int>(row));
        if (point.exists()) count += match(&point);
      }
    }
    num_patches[begin / kRowsOfBlock] = count;
  });
  size_t total = 0;
  for (const size_t count : num_patches) total += count;
  return total;
}

// Points around that have a match, nearest first.
struct Guides {
  static constexpr int kMaxCount = 9;
  const InterestPoint* points[kMaxCount];
  float squared_distance[kMaxCount];
  int count = 0;
  uint32_t slots = 0;

  void Add(const InterestPoint& point, const Eigen::Vector2f& position) {
    slots |= point.slots;
    const float distance = (point.position - position).squaredNorm();
    int place = count < kMaxCount ? count++ : kMaxCount;
    while (place > 0 && squared_distance[place - 1] > distance) {
      if (place < kMaxCount) {
        points[place] = points[place - 1];
        squared_distance[place] = squared_distance[place - 1];
      }
      --place;
    }
    if (place == kMaxCount) return;
    points[place] = &point;
    squared_distance[place] = distance;
  }
};

// The nearest matched points within `reach` cells, or within up to `max_reach` if there is none.
Guides FindGuides(const PointGrid& grid, const Eigen::Vector2f& position, int reach,
                  int max_reach) {
  Guides guides;
  for (; reach <= max_reach && guides.count == 0; ++reach) {
    ForPointsAround(grid, position, reach, [&](const InterestPoint& point) {
      if (point.matched()) guides.Add(point, position);
    });
  }
  return guides;
}

}  // namespace

size_t SearchRange(const SearchView& view, const RunContext& context, PointGrid* grid) {
  return ForPoints(context, grid, [&](InterestPoint* point) {
    PointSearch search(view, point->position);
    search.UseSlots(~0u, view.num_searched);
    search.Sweep();
    search.Refine(kRefineStepPx);
    StoreMatch(view, search, point);
    return search.num_patches();
  });
}

size_t SearchFromCoarser(const SearchView& view, const PointGrid& coarser,
                         const Eigen::Vector2f& scale, const RunContext& context, PointGrid* grid) {
  return ForPoints(context, grid, [&](InterestPoint* point) {
    const Eigen::Vector2f place = point->position.cwiseQuotient(scale);
    const Guides guides = FindGuides(coarser, place, 1, 3);
    PointSearch search(view, point->position);
    search.UseSlots(guides.slots, view.num_compared);
    for (int k = 0; k < guides.count; ++k) {
      const InterestPoint& guide = *guides.points[k];
      const Plane plane = MovePlane(guide.plane, place - guide.position, scale);
      if (plane.known() && !search.Tried(plane.q)) search.Try(plane);
    }
    search.Refine(kRefineStepPx);
    StoreMatch(view, search, point);
    return search.num_patches();
  });
}

size_t Propagate(const SearchView& view, const RunContext& context, PointGrid* grid) {
  const PointGrid before = *grid;
  return ForPoints(context, grid, [&](InterestPoint* point) {
    const Guides guides = FindGuides(before, point->position, 1, 1);
    PointSearch search(view, point->position);
    search.UseSlots(guides.slots | point->slots, view.num_compared);
    if (point->matched()) {
      const float tolerance = kMatchErrorPx * search.StepAt(point->plane.q);
      const Plane fit = tolerance > 0
                            ? FitPlane(before, point->position, point->plane, tolerance, kFitReach)
                            : point->plane;
      search.Try(fit);
      search.Try({point->plane.q, fit.qx, fit.qy});
    }
    for (int k = 0; k < guides.count; ++k) {
      const InterestPoint& guide = *guides.points[k];
      const Plane plane = MovePlane(guide.plane, point->position - guide.position, {1.0f, 1.0f});
      if (plane.known() && !search.Tried(plane.q)) search.Try(plane);
    }
    search.Refine(kRefineStepPx);
    StoreMatch(view, search, point);
    return search.num_patches();
  });
}

}  // namespace lsmvs::quasi_dense
