#include "lsmvs/util/memory.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace lsmvs {
namespace {

TEST(Memory, SomeIsAvailable) {
  EXPECT_GT(AvailableMemoryBytes(), size_t{10} << 20);
  EXPECT_LT(AvailableMemoryBytes(), size_t{1} << 50);
}

// Holds so much memory for a while.
void Hold(size_t num_bytes) {
  const std::vector<char> touched(num_bytes, 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
}

// Each watch sees its own time; the mark of the whole process stays.
TEST(PeakMemoryWatch, TellsThePeakOfItsOwnTime) {
  ReturnLargeBlocksWhenFreed();
  constexpr size_t kLarge = size_t{96} << 20, kSmall = size_t{48} << 20;
#if defined(__SANITIZE_ADDRESS__)
  constexpr size_t kSlack = (size_t{8} << 20) + kLarge / 8;  // the sanitizer's shadow of the block
#else
  constexpr size_t kSlack = size_t{8} << 20;
#endif
  size_t high = 0;
  {
    const PeakMemoryWatch watch;
    Hold(kLarge);
    high = watch.PeakBytes();
    EXPECT_NEAR(static_cast<double>(high), static_cast<double>(watch.bytes_before() + kLarge),
                static_cast<double>(kSlack));
  }
  const PeakMemoryWatch watch;
  Hold(kSmall);
  EXPECT_NEAR(static_cast<double>(watch.PeakBytes()),
              static_cast<double>(watch.bytes_before() + kSmall), static_cast<double>(kSlack));
  EXPECT_GE(PeakResidentBytes(), high);
}

// A new mark is told exactly, however short the peak was.
TEST(PeakMemoryWatch, SeesAShortPeakThatIsTheHighestSoFar) {
  ReturnLargeBlocksWhenFreed();
  constexpr size_t kBytes = size_t{256} << 20;
  const PeakMemoryWatch watch;
  { const std::vector<char> touched(kBytes, 1); }
  EXPECT_GE(watch.PeakBytes() + kBytes / 100, watch.bytes_before() + kBytes);
}

TEST(ReturnFreedMemory, GivesSmallBlocksBack) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "memory is counted without sanitizers";
#endif
  constexpr size_t kBlock = 1000, kCount = 64000;
  std::vector<std::vector<char>> blocks(kCount);
  for (auto& block : blocks) block.assign(kBlock, 1);
  const size_t full = ResidentBytes();
  // Every block but the last, so that the heap cannot shrink from its end.
  blocks.erase(blocks.begin(), blocks.end() - 1);
  ReturnFreedMemory();
  EXPECT_LT(ResidentBytes() + kBlock * kCount / 2, full);
}

TEST(FormatBytes, CountsInPowersOfTen) {
  EXPECT_EQ(FormatBytes(0), "0 MB");
  EXPECT_EQ(FormatBytes(20000000), "20 MB");
  EXPECT_EQ(FormatBytes(20000001), "21 MB");
  EXPECT_EQ(FormatBytes(1500000000), "1.5 GB");
  EXPECT_EQ(FormatBytes(size_t{20} << 30), "21 GB");
}

}  // namespace
}  // namespace lsmvs
