#include "lsmvs/texturing/candidates/face_candidates.h"

#include <algorithm>

namespace lsmvs {

static_assert(sizeof(Candidate) == 12);

void FaceCandidates::Add(size_t face, Candidate candidate, float density) {
  density_[face] = std::max(density_[face], density);
  Candidate* begin = Begin(face);
  size_t at = counts_[face];
  while (at > 0 && begin[at - 1].quality < candidate.quality) --at;
  if (at >= max_per_face_) return;
  counts_[face] = static_cast<uint8_t>(std::min<size_t>(max_per_face_, counts_[face] + 1u));
  std::move_backward(begin + at, begin + counts_[face] - 1, begin + counts_[face]);
  begin[at] = candidate;
}

const Candidate* FaceCandidates::Find(size_t face, int view_idx) const {
  for (const Candidate& candidate : Of(face)) {
    if (candidate.view_idx == view_idx) return &candidate;
  }
  return nullptr;
}

void FaceCandidates::Sort(size_t face) {
  const std::span<Candidate> candidates = Of(face);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.quality > b.quality; });
}

void FaceCandidates::Compact() {
  std::vector<uint32_t> begin(num_faces());
  size_t end = 0;
  for (size_t f = 0; f < num_faces(); ++f) {
    std::copy_n(Begin(f), counts_[f], candidates_.data() + end);
    begin[f] = static_cast<uint32_t>(end);
    end += counts_[f];
  }
  begin_.swap(begin);
  candidates_.resize(end);
  candidates_.shrink_to_fit();
}

}  // namespace lsmvs
