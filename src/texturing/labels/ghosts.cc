#include "lsmvs/texturing/labels/ghosts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lsmvs {

namespace {

constexpr size_t kFacesPerBlock = 8192;
constexpr size_t kMinCandidates = 3;
constexpr float kLeastDeviation = 4;  // grey levels
constexpr float kMadToSigma = 1.4826f;
constexpr int kUnit = 16;  // of stored deviations: 1 / 16
constexpr int kReject = 4 * kUnit, kJoin = 2 * kUnit;
constexpr int kSmoothings = 3;
constexpr int kGrowths = 8;

struct Weighted {
  float value, weight;
};

// Lower weighted median.
float WeightedMedian(std::vector<Weighted>* values) {
  std::sort(values->begin(), values->end(), [](const Weighted& a, const Weighted& b) {
    return a.value != b.value ? a.value < b.value : a.weight < b.weight;
  });
  float total = 0, sum = 0;
  for (const Weighted& v : *values) total += v.weight;
  for (const Weighted& v : *values) {
    sum += v.weight;
    if (2 * sum >= total) return v.value;
  }
  return values->back().value;
}

// Deviations of the candidates of one face, the largest of the three channels, in 1 / kUnit.
void FindDeviations(std::span<const Candidate> candidates, uint8_t* out) {
  std::fill_n(out, candidates.size(), uint8_t{0});
  if (candidates.size() < kMinCandidates) return;
  std::vector<Weighted> values;
  for (int c = 0; c < 3; ++c) {
    values.clear();
    for (const Candidate& k : candidates) {
      values.push_back({static_cast<float>(k.color[c]), k.quality});
    }
    const float median = WeightedMedian(&values);
    for (Weighted& v : values) v.value = std::abs(v.value - median);
    const float scale = std::max(kLeastDeviation, kMadToSigma * WeightedMedian(&values));
    for (size_t k = 0; k < candidates.size(); ++k) {
      const float deviation = std::abs(static_cast<float>(candidates[k].color[c]) - median);
      const int stored = static_cast<int>(static_cast<float>(kUnit) * deviation / scale);
      out[k] = static_cast<uint8_t>(std::clamp<int>(stored, out[k], 255));
    }
  }
}

class GhostFinder {
 public:
  GhostFinder(const FaceNeighbors& neighbors, const FaceCandidates& candidates,
              const RunContext& context)
      : neighbors_(neighbors), candidates_(candidates), context_(context) {}

  // Per candidate, 1 for those that show something else.
  std::vector<uint8_t> Run() {
    std::vector<uint8_t> own(candidates_.num_candidates());
    ParallelFor(context_, candidates_.num_faces(), kFacesPerBlock, [&](size_t f) {
      FindDeviations(candidates_.Of(f), own.data() + candidates_.FirstIndex(f));
    });
    std::vector<uint8_t> mean = own;
    for (int i = 0; i < kSmoothings; ++i) Smooth(&mean);
    std::vector<uint8_t> ghost(own.size());
    for (size_t k = 0; k < own.size(); ++k) ghost[k] = mean[k] > kReject;
    for (int i = 0; i < kGrowths; ++i) Grow(own, kJoin, &ghost);
    Grow(own, 0, &ghost);
    return ghost;
  }

 private:
  // Calls visit(position) for the candidates of the neighbouring faces that are of the same view.
  template <class Visit>
  void ForSameView(size_t face, int view_idx, const Visit& visit) const {
    for (const int32_t other : neighbors_[face]) {
      if (other < 0) continue;
      const auto of_other = candidates_.Of(static_cast<size_t>(other));
      for (size_t k = 0; k < of_other.size(); ++k) {
        if (of_other[k].view_idx != view_idx) continue;
        visit(candidates_.FirstIndex(static_cast<size_t>(other)) + k);
      }
    }
  }

  // Calls body(view, position) for each candidate; results go to another array than they come from.
  template <class Body>
  void ForCandidates(const Body& body) const {
    ParallelFor(context_, candidates_.num_faces(), kFacesPerBlock, [&](size_t f) {
      const auto of_face = candidates_.Of(f);
      for (size_t k = 0; k < of_face.size(); ++k) {
        body(f, of_face[k].view_idx, candidates_.FirstIndex(f) + k);
      }
    });
  }

  void Smooth(std::vector<uint8_t>* values) const {
    std::vector<uint8_t> smooth(values->size());
    ForCandidates([&](size_t f, int view_idx, size_t at) {
      int sum = (*values)[at], count = 1;
      ForSameView(f, view_idx, [&](size_t other) {
        sum += (*values)[other];
        ++count;
      });
      smooth[at] = static_cast<uint8_t>(sum / count);
    });
    values->swap(smooth);
  }

  void Grow(const std::vector<uint8_t>& own, int threshold, std::vector<uint8_t>* ghost) const {
    std::vector<uint8_t> grown = *ghost;
    ForCandidates([&](size_t f, int view_idx, size_t at) {
      if ((*ghost)[at] != 0 || own[at] < threshold) return;
      ForSameView(f, view_idx, [&](size_t other) { grown[at] |= (*ghost)[other]; });
    });
    ghost->swap(grown);
  }

  const FaceNeighbors& neighbors_;
  const FaceCandidates& candidates_;
  const RunContext& context_;
};

}  // namespace

size_t DropGhosts(const FaceNeighbors& neighbors, FaceCandidates* candidates,
                  const RunContext& context) {
  const std::vector<uint8_t> ghost = GhostFinder(neighbors, *candidates, context).Run();
  size_t num_dropped = 0;
  for (size_t f = 0; f < candidates->num_faces(); ++f) {
    const size_t count = candidates->Of(f).size();
    const uint8_t* flags = ghost.data() + candidates->FirstIndex(f);
    const auto num_ghosts = static_cast<size_t>(std::count(flags, flags + count, 1));
    if (num_ghosts == 0 || num_ghosts == count) continue;
    candidates->Filter(f, [&](size_t k) { return flags[k] == 0; });
    num_dropped += num_ghosts;
  }
  return num_dropped;
}

}  // namespace lsmvs
