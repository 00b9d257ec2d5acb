#include "lsmvs/synthetic/shuffled_cloud.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace lsmvs {

ShuffledCloud Shuffle(const VisibilityCloud& cloud, uint64_t seed) {
  ShuffledCloud shuffled;
  shuffled.origin.resize(cloud.size());
  std::iota(shuffled.origin.begin(), shuffled.origin.end(), size_t{0});
  std::shuffle(shuffled.origin.begin(), shuffled.origin.end(), std::mt19937_64(seed));
  shuffled.cloud.Reserve(cloud.size(), cloud.view_idxs.size());
  for (const size_t p : shuffled.origin) {
    shuffled.cloud.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], cloud.ViewsOf(p));
  }
  return shuffled;
}

}  // namespace lsmvs
