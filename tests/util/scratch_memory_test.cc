#include "lsmvs/util/scratch_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {
namespace {

constexpr size_t kMegabyte = 1 << 20;

// `extra` megabytes beside what the process has, a few of which are slack.
ScratchMemoryOptions OptionsFor(const TemporaryFolder& folder, size_t extra) {
  return {folder.path(), ResidentBytes() + extra * kMegabyte};
}

uint32_t Noise(uint32_t i) { return i * 2654435761u ^ (i >> 7); }

class ScratchMemoryTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!ScratchMemory::IsAvailable()) GTEST_SKIP() << "not in this build";
  }
  TemporaryFolder folder_;
};

TEST_F(ScratchMemoryTest, SortsMoreThanFitsIntoMemoryAndStaysBelowTheLimit) {
  constexpr uint32_t kCount = 72u << 20 >> 2;  // 72 MiB
  const PeakMemoryWatch watch;
  const ScratchMemoryOptions options = OptionsFor(folder_, 60);
  {
    const ScratchMemory scratch(options);
    std::vector<uint32_t> values(kCount);
    for (uint32_t i = 0; i < kCount; ++i) values[i] = Noise(i);
    const uint64_t sum = std::accumulate(values.begin(), values.end(), uint64_t{0});
    std::sort(values.begin(), values.end());
    EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
    EXPECT_EQ(std::accumulate(values.begin(), values.end(), uint64_t{0}), sum);
    EXPECT_GE(ScratchMemory::BytesInUse(), kCount * sizeof(uint32_t));
  }
  EXPECT_EQ(ScratchMemory::BytesInUse(), 0u);
  EXPECT_GT(ScratchMemory::BytesWritten(), 20 * kMegabyte);
  EXPECT_GT(ScratchMemory::BytesRead(), 20 * kMegabyte);
  EXPECT_LE(watch.PeakBytes(), options.max_resident_bytes);
}

TEST_F(ScratchMemoryTest, RandomAccessReadsBackWhatWasWritten) {
  constexpr size_t kCount = 64 * kMegabyte / sizeof(uint64_t);
  const ScratchMemory scratch(OptionsFor(folder_, 50));
  std::vector<uint64_t> values(kCount, 0);
  std::vector<uint64_t> expected_of(1000);
  std::mt19937_64 random(1);
  std::vector<size_t> places;
  for (size_t k = 0; k < expected_of.size(); ++k) {
    places.push_back(random() % kCount);
    values[places[k]] = k + 1;
    expected_of[k] = k + 1;
  }
  for (size_t k = places.size(); k-- > 0;) {
    // A later one may have taken the place.
    EXPECT_GE(values[places[k]], expected_of[k]);
  }
  const auto num_set = std::count_if(values.begin(), values.end(), [](auto v) { return v != 0; });
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  EXPECT_EQ(static_cast<size_t>(num_set), places.size());
}

TEST_F(ScratchMemoryTest, ThreadsShareChunksThatComeAndGo) {
  constexpr size_t kCount = 48 * kMegabyte / sizeof(uint32_t);
  constexpr uint32_t kNumThreads = 4;
  const ScratchMemory scratch(OptionsFor(folder_, 50));
  std::vector<uint32_t> values(kCount, 0);
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < kNumThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int round = 0; round < 3; ++round) {
        for (size_t i = t; i < kCount; i += kNumThreads) {
          __atomic_fetch_add(&values[i], static_cast<uint32_t>(i), __ATOMIC_RELAXED);
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  size_t num_wrong = 0;
  for (size_t i = 0; i < kCount; ++i) num_wrong += values[i] != 3 * static_cast<uint32_t>(i);
  EXPECT_EQ(num_wrong, 0u);
}

TEST_F(ScratchMemoryTest, SmallBlocksAndBlocksOfBeforeStayInMemory) {
  std::vector<char> before(2 * kMinScratchBlock, 'a');
  const ScratchMemory scratch(OptionsFor(folder_, 60));
  const std::vector<char> small(kMinScratchBlock - 1, 'b');
  EXPECT_EQ(ScratchMemory::BytesInUse(), 0u);
  const std::vector<char> large(kMinScratchBlock, 'c');
  EXPECT_EQ(ScratchMemory::BytesInUse(), kMinScratchBlock);
  EXPECT_EQ(large.back(), 'c');
}

TEST_F(ScratchMemoryTest, BlocksMayOutliveIt) {
  std::optional<ScratchMemory> scratch(std::in_place, OptionsFor(folder_, 50));
  auto values = std::make_unique<std::vector<int>>(20 * kMegabyte / sizeof(int), 7);
  scratch.reset();
  EXPECT_EQ(std::count(values->begin(), values->end(), 7), 20 * kMegabyte / sizeof(int));
  values.reset();
  EXPECT_EQ(ScratchMemory::BytesInUse(), 0u);
}

TEST_F(ScratchMemoryTest, LeavesNoFile) {
  const ScratchMemory scratch(OptionsFor(folder_, 50));
  const std::vector<char> large(2 * kMinScratchBlock, 'c');
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(ScratchMemoryTest, FolderThatIsMissingIsRefused) {
  EXPECT_THROW(ScratchMemory({folder_.path() / "missing", 100 * kMegabyte}), FileSystemError);
  EXPECT_FALSE(ScratchMemory::IsOn());
}

TEST_F(ScratchMemoryTest, FullDiskIsMetWhenABlockIsMade) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before = {};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit limit = {30 * kMegabyte, before.rlim_max};
  const ScratchMemory scratch(OptionsFor(folder_, 60));
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const std::vector<char> fits(16 * kMegabyte, 'a');
  try {
    const std::vector<char> too_large(64 * kMegabyte, 'a');
    ADD_FAILURE() << "64 MB fitted into 30";
  } catch (const ScratchFullError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(folder_.path().string()));
    EXPECT_THAT(error.what(), testing::HasSubstr("--scratch_path"));
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(fits.back(), 'a');
}

TEST_F(ScratchMemoryTest, OtherFaultsStillEndTheProcess) {
  const ScratchMemory scratch(OptionsFor(folder_, 50));
  testing::FLAGS_gtest_death_test_style = "fast";
  volatile uintptr_t nowhere = 16;
  const auto touch = [&] { *reinterpret_cast<volatile int*>(nowhere) = 1; };
  EXPECT_EXIT(touch(), testing::KilledBySignal(SIGSEGV), "");
  EXPECT_EXIT(std::raise(SIGSEGV), testing::KilledBySignal(SIGSEGV), "");
}

TEST_F(ScratchMemoryTest, TailsAreGivenBackAndMayBeUsedAgain) {
  const ScratchMemory scratch(OptionsFor(folder_, 64));
  std::vector<uint32_t> values;
  values.reserve(32 * kMegabyte / sizeof(uint32_t));
  const uint64_t whole = ScratchMemory::BytesInUse();
  EXPECT_EQ(whole, 32 * kMegabyte);
  for (uint32_t i = 0; i < 5 * kMegabyte / sizeof(uint32_t); ++i) values.push_back(Noise(i));
  ScratchMemory::GiveBackTail(values.data(), values.size() * sizeof(uint32_t));
  EXPECT_EQ(ScratchMemory::BytesInUse(), 6 * kMegabyte);
  for (auto i = static_cast<uint32_t>(values.size()); i < 30 * kMegabyte / sizeof(uint32_t); ++i) {
    values.push_back(Noise(i));
  }
  for (uint32_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], Noise(i));
  std::vector<uint32_t>().swap(values);
  EXPECT_EQ(ScratchMemory::BytesInUse(), 0u);
  int other = 0;
  EXPECT_NO_THROW(ScratchMemory::GiveBackTail(&other, 0));
}

}  // namespace
}  // namespace lsmvs
