#include "lsmvs/util/memory.h"

#include <gtest/gtest.h>

#include <vector>

namespace lsmvs {
namespace {

TEST(Memory, SomeIsAvailable) {
  EXPECT_GT(AvailableMemoryBytes(), size_t{10} << 20);
  EXPECT_LT(AvailableMemoryBytes(), size_t{1} << 50);
}

TEST(Memory, PeakFollowsAnAllocationAndCanBeReset) {
  constexpr size_t kBytes = size_t{96} << 20;
  ResetPeakResidentBytes();
  const size_t before = PeakResidentBytes();
  EXPECT_GT(before, size_t{1} << 20);
  { const std::vector<char> touched(kBytes, 1); }
  const size_t high = PeakResidentBytes();
  EXPECT_GE(high, before + kBytes / 2);
  ResetPeakResidentBytes();
  // Where the kernel does not let us reset, the peak stays; it never grows by that. The rest of the
  // process may touch some pages meanwhile.
  EXPECT_LE(PeakResidentBytes(), high + kBytes / 16);
}

}  // namespace
}  // namespace lsmvs
