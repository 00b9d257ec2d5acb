#include "lsmvs/merging/zip/bridges.h"

#include <algorithm>
#include <cstdint>

namespace lsmvs {

namespace {

// Vertices of a rim between two bridges, about.
constexpr size_t kBridgeSpacing = 4;

}  // namespace

std::vector<Bridge> LongestRisingChain(const std::vector<Bridge>& bridges) {
  std::vector<size_t> tails;  // of chains of each length, the one that ends lowest
  std::vector<int64_t> before(bridges.size(), -1);
  for (size_t k = 0; k < bridges.size(); ++k) {
    const auto at = std::lower_bound(tails.begin(), tails.end(), bridges[k].j,
                                     [&](size_t t, size_t j) { return bridges[t].j < j; });
    if (at != tails.begin()) before[k] = static_cast<int64_t>(*(at - 1));
    if (at == tails.end()) {
      tails.push_back(k);
    } else {
      *at = k;
    }
  }
  std::vector<Bridge> chain;
  for (int64_t k = static_cast<int64_t>(tails.back()); k >= 0; k = before[static_cast<size_t>(k)]) {
    chain.push_back(bridges[static_cast<size_t>(k)]);
  }
  std::reverse(chain.begin(), chain.end());
  return chain;
}

std::vector<Bridge> ThinnedChain(const std::vector<Bridge>& bridges) {
  std::vector<Bridge> thinned = {bridges.front()};
  for (size_t k = 1; k < bridges.size();) {
    const auto advance = [&](size_t m) {
      return std::max(bridges[m].i - thinned.back().i, bridges[m].j - thinned.back().j);
    };
    size_t best = k;
    for (size_t m = k; m < bridges.size() && advance(m) <= 2 * kBridgeSpacing; ++m) {
      const bool is_far = advance(m) >= kBridgeSpacing;
      if (advance(best) < kBridgeSpacing ? is_far || m > best
                                         : is_far && bridges[m].length < bridges[best].length) {
        best = m;
      }
    }
    thinned.push_back(bridges[best]);
    k = best + 1;
  }
  return thinned;
}

}  // namespace lsmvs
