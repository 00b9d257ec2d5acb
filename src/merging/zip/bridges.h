#pragma once

#include <cstddef>
#include <vector>

namespace lsmvs {

// Joins a vertex of one rim to one of the other.
struct Bridge {
  size_t i, j;    // positions on the loop of the first surface and, counted backwards, the second
  double length;  // in edge lengths
};

// Bridges, sorted by (i, j), that follow each other on both loops: as many as possible. The first
// one must be (0, 0). O(n log n).
std::vector<Bridge> LongestRisingChain(const std::vector<Bridge>& bridges);

// Of a rising chain one bridge in about four vertices: the shortest ones, and the first.
std::vector<Bridge> ThinnedChain(const std::vector<Bridge>& bridges);

}  // namespace lsmvs
