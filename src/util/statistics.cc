#include "lsmvs/util/statistics.h"

#include <array>
#include <bit>
#include <cstdint>

namespace lsmvs {

std::optional<double> MedianOfPositive(
    const std::function<void(const std::function<void(double)>&)>& for_all) {
  // The bits of positive numbers are ordered as the numbers are: they are found from the highest.
  constexpr std::array kBitsOfPass = {22, 21, 21};
  uint64_t prefix = 0, rank = 0;
  int shift = 64;
  for (const int bits : kBitsOfPass) {
    const int upper = shift;
    shift -= bits;
    std::vector<uint64_t> counts(size_t{1} << bits, 0);
    uint64_t num_values = 0;
    for_all([&](double value) {
      const auto code = std::bit_cast<uint64_t>(value);
      if (upper < 64 && code >> upper != prefix) return;
      ++counts[code >> shift & (counts.size() - 1)];
      ++num_values;
    });
    if (num_values == 0) return std::nullopt;
    if (upper == 64) rank = num_values / 2;
    size_t digit = 0;
    for (; rank >= counts[digit]; ++digit) rank -= counts[digit];
    prefix = prefix << bits | digit;
  }
  return std::bit_cast<double>(prefix);
}

}  // namespace lsmvs
