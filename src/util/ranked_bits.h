#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lsmvs {

// A subset of 0, 1, ..., n - 1 that knows the place of each member in it: for arrays that hold
// something for few of many elements. 3/16 of a byte for each of the n.
class RankedBits {
 public:
  // None of `size` elements; memory of before is used again.
  void Assign(size_t size) {
    words_.assign((size + kBits - 1) / kBits, 0);
    ranks_.clear();
  }

  void Set(size_t element) { words_[element / kBits] |= uint64_t{1} << element % kBits; }
  void Clear(size_t element) { words_[element / kBits] &= ~(uint64_t{1} << element % kBits); }

  // Numbers the members in ascending order; before the first Rank(), and after the last Set() and
  // Clear().
  void Rank() {
    ranks_.clear();
    ranks_.reserve(words_.size());
    uint32_t rank = 0;
    for (const uint64_t word : words_) {
      ranks_.push_back(rank);
      rank += static_cast<uint32_t>(std::popcount(word));
    }
  }

  // The number of members before the element, or -1 if it is none.
  int32_t RankOf(size_t element) const {
    const uint64_t word = words_[element / kBits], bit = uint64_t{1} << element % kBits;
    if ((word & bit) == 0) return -1;
    return static_cast<int32_t>(ranks_[element / kBits]) + std::popcount(word & (bit - 1));
  }

  // Calls visit(element) for the members in ascending order. `visit` may clear the element.
  template <class Visit>
  void ForEach(const Visit& visit) const {
    for (size_t w = 0; w < words_.size(); ++w) {
      for (uint64_t rest = words_[w]; rest != 0; rest &= rest - 1) {
        visit(w * kBits + static_cast<size_t>(std::countr_zero(rest)));
      }
    }
  }

 private:
  static constexpr size_t kBits = 64;

  std::vector<uint64_t> words_;
  std::vector<uint32_t> ranks_;  // as words_
};

}  // namespace lsmvs
