#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/surface/weights/saturated_sum.h"

namespace lsmvs::internal {

// The far parts of rays that run to one view. A ray that goes through the same kRun cells as an
// earlier one joins it and takes its way from there on, so that a facet costs one step whatever the
// number of rays through it. Far from their vertices all rays weigh the same whatever the distance:
// only the sums per facet matter, and what leaves a cell still equals what enters it. A ray is
// moved by the size of a cell or less each time it joins another. The weights are carried along the
// paths at the end.
class JoinedPaths {
 public:
  static constexpr int kRun = 2;

  // For a complex of `num_cells`: 4 bytes each, and 12 for each step of Enter.
  explicit JoinedPaths(size_t num_cells) : step_of_(num_cells, kNone) {}

  // A path of `weight` > 0 sets off.
  void Begin(int32_t weight) {
    paths_.push_back({steps_.size(), kNone, 0, weight});
    run_ = 0;
    last_ = kNone - 1;
  }
  // It enters `cell` through its facet `facet`. True if it goes on by itself; false if it joined.
  bool Enter(int32_t cell, int facet) {
    uint32_t& step = step_of_[cell];
    if (step == kNone) {
      step = static_cast<uint32_t>(steps_.size());
      run_ = 0;
      last_ = kNone - 1;
    } else {
      run_ = step == last_ + 1 ? run_ + 1 : 1;
      last_ = step;
      if (run_ == kRun) {
        paths_.back().joined = step;
        paths_.back().facet = static_cast<uint8_t>(facet);
        return false;
      }
    }
    steps_.push_back({cell, 0, static_cast<uint8_t>(facet)});
    return true;
  }

  // Calls add_to_facet(cell, facet, weight) for all that was entered and end_in(cell) where paths
  // end, and forgets them.
  template <class AddToFacet, class EndIn>
  void Carry(const AddToFacet& add_to_facet, const EndIn& end_in);

 private:
  static constexpr uint32_t kNone = 0xFFFFFFFFu;
  struct Path {
    size_t begin;     // in steps_, up to the next path's
    uint32_t joined;  // step, or kNone
    uint8_t facet;    // through which it entered that step's cell
    int32_t weight;
  };
  struct Step {
    int32_t cell;
    int32_t joined_weight;  // of the paths that joined here
    uint8_t facet;
  };

  std::vector<uint32_t> step_of_;  // by cell: the first that entered it
  std::vector<Path> paths_;
  std::vector<Step> steps_;
  int run_ = 0;        // cells in a row that the path shares with another
  uint32_t last_ = 0;  // the step in the last of them
};

template <class AddToFacet, class EndIn>
void JoinedPaths::Carry(const AddToFacet& add_to_facet, const EndIn& end_in) {
  // A path joins earlier ones only: the last ones first.
  size_t end = steps_.size();
  for (size_t i = paths_.size(); i-- > 0;) {
    const Path& path = paths_[i];
    int32_t weight = path.weight;
    for (size_t k = path.begin; k < end; ++k) {
      add_to_facet(steps_[k].cell, steps_[k].facet, weight);
      weight = AddCapacities(weight, steps_[k].joined_weight);
    }
    if (path.joined == kNone) {
      end_in(steps_[end - 1].cell);
    } else {
      Step& step = steps_[path.joined];
      add_to_facet(step.cell, path.facet, weight);
      step.joined_weight = AddCapacities(step.joined_weight, weight);
    }
    end = path.begin;
  }
  for (const Step& step : steps_) step_of_[step.cell] = kNone;
  paths_.clear();
  steps_.clear();
}

}  // namespace lsmvs::internal
