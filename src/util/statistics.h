#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace lsmvs {

// Order statistics without a full sort: O(n), the values are reordered. `values` is not empty.

// The value of which `rank` others are not above: rank 0 is the smallest.
template <class T>
T ValueOfRank(std::vector<T>* values, size_t rank) {
  const auto place = values->begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values->begin(), place, values->end());
  return *place;
}

// Of an even number of values the upper of the two in the middle: always one of the values.
template <class T>
T Median(std::vector<T>* values) {
  return ValueOfRank(values, values->size() / 2);
}

// The same of positive values that are not held: `for_all` calls its argument with each of them, in
// any order, up to three times. Nothing if there are none. Memory: 32 MB, whatever their number.
std::optional<double> MedianOfPositive(
    const std::function<void(const std::function<void(double)>&)>& for_all);

// The value at `share` (0 to 1) of the way from the smallest to the largest, rounded down to a
// rank.
template <class T>
T Quantile(std::vector<T>* values, double share) {
  return ValueOfRank(values, static_cast<size_t>(share * static_cast<double>(values->size() - 1)));
}

}  // namespace lsmvs
