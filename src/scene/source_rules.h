#pragma once

#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"

namespace lsmvs {

// Where the neighbours of a view come from, when the user says so.
struct SourceRule {
  enum class Kind {
    kBest,    // those that SelectNeighbors found, `max_count` at most
    kAll,     // these, and then all others, nearest first
    kListed,  // `view_idxs`, in that order
    kNone,    // none: the view gets no depth
  };
  Kind kind = Kind::kBest;
  int max_count = 0;  // 0: no limit
  std::vector<int> view_idxs;
};

// Whether the rules change nothing of lists of at most `max_num_neighbors`.
bool ChangeNothing(const std::vector<SourceRule>& rules, int max_num_neighbors);

// Replaces the neighbours that were selected by what the rules say, one a view. Views without photo
// are nobody's neighbours and have none.
void ApplySourceRules(const Scene& scene, const std::vector<SourceRule>& rules,
                      std::vector<std::vector<Neighbor>>* neighbors);

}  // namespace lsmvs
