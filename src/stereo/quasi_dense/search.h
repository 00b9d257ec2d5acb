#pragma once

#include <memory>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/stereo/quasi_dense/pairs.h"
#include "lsmvs/stereo/quasi_dense/points.h"
#include "lsmvs/stereo/quasi_dense/window.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs::quasi_dense {

// What the search of one view on one scale works on.
struct SearchView {
  std::shared_ptr<const PackedImage> image;
  std::vector<Pairing> pairings;                           // slot s is pairings[s]
  std::vector<std::shared_ptr<const PackedImage>> others;  // images of the neighbours, by slot
  WindowPattern pattern;
  // Inverse depths searched, 0 < nearest after farthest.
  float min_inverse_depth = 0, max_inverse_depth = 0;
  int num_searched = 8;  // slots of the coarsest search: those before it
  int num_compared = 4;  // slots compared for a point whose matching neighbours are known
  float min_ncc = 0.6f;  // of a slot that matches, and of the mean score of a point that does
};

// Score of a hypothesis: mean ZNCC over the best kNumBest neighbours; one that does not see the
// window counts 0.
inline constexpr int kNumBest = 3;

// Compares one point's window along its epipolar segments. Kept on the stack of a thread.
class PointSearch {
 public:
  PointSearch(const SearchView& view, const Eigen::Vector2f& position);

  // Restricts the comparison to these slots: those of the mask in order, filled up to at least two
  // with the best others.
  void UseSlots(uint32_t mask, int max_count);
  // Compares the window warped by `plane`; keeps the best.
  void Try(const Plane& plane);
  // Whether a plane within half a step of this one has been tried.
  bool Tried(float inverse_depth) const;
  // Tries every step (a pixel of parallax on average) of the range.
  void Sweep();
  // Climbs to the maximum near the best hypothesis in steps of `step_px`, then takes the maximum of
  // the parabola through it and its neighbours.
  void Refine(float step_px);

  // Change of inverse depth that is a pixel of parallax, average over the slots in use, at the
  // depth given. 0 if none sees the point.
  float StepAt(float inverse_depth) const;

  bool found() const { return best_.known(); }
  const Plane& best() const { return best_; }
  float score() const { return score_; }
  uint32_t slots() const { return slots_; }
  size_t num_patches() const { return num_patches_; }
  bool textured(float noise_sigma) const { return reference_.deviation > noise_sigma; }

 private:
  static constexpr int kMaxTried = 16;
  struct Outcome {
    float score = -2;
    uint32_t slots = 0;
  };
  Outcome Compare(const Plane& plane);

  const SearchView& view_;
  Eigen::Vector2f position_;
  ReferenceWindow reference_;
  int in_use_[32];
  int num_in_use_ = 0;
  Plane best_;
  float score_ = -2;
  uint32_t slots_ = 0;
  float tried_[kMaxTried];
  int num_tried_ = 0;
  size_t num_patches_ = 0;
};

// Each returns the number of windows compared and writes the match of every point of `grid` (best
// plane, score, slots; unmatched below min_ncc). The same for any number of threads.

// Over the whole depth range, fronto-parallel.
size_t SearchRange(const SearchView& view, const RunContext& context, PointGrid* grid);
// Around the planes of the points nearby on a coarser scale, whose image coordinates times `scale`
// are those of `grid`.
size_t SearchFromCoarser(const SearchView& view, const PointGrid& coarser,
                         const Eigen::Vector2f& scale, const RunContext& context, PointGrid* grid);
// Tries the planes through the points around and those of the neighbours; also for points without
// a match. Reads the grid as it was before.
size_t Propagate(const SearchView& view, const RunContext& context, PointGrid* grid);

}  // namespace lsmvs::quasi_dense
