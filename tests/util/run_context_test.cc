#include "lsmvs/util/run_context.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

std::set<std::pair<size_t, size_t>> BlocksOf(const RunContext& context, size_t count,
                                             size_t block) {
  std::set<std::pair<size_t, size_t>> blocks;
  std::mutex mutex;
  ParallelBlocks(context, count, block, [&](size_t begin, size_t end) {
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_TRUE(blocks.emplace(begin, end).second) << "block seen twice";
  });
  return blocks;
}

TEST(ParallelBlocks, CoverTheRangeOnceAndDoNotDependOnThreads) {
  for (const size_t count : {0u, 1u, 9u, 10u, 11u, 1000u}) {
    for (const size_t block : {1u, 10u, 5000u}) {
      const auto one = BlocksOf(RunContext(1), count, block);
      EXPECT_EQ(one, BlocksOf(RunContext(4), count, block));
      size_t expected_begin = 0;
      for (const auto& [begin, end] : one) {
        EXPECT_EQ(begin, expected_begin);
        EXPECT_LE(end - begin, block);
        EXPECT_GT(end, begin);
        expected_begin = end;
      }
      EXPECT_EQ(expected_begin, count);
    }
  }
}

TEST(ParallelBlocks, SumsInBlockOrderAreTheSameBytes) {
  constexpr size_t kCount = 100000, kBlock = 777;
  const auto sum = [&](int num_threads) {
    std::vector<float> partial((kCount + kBlock - 1) / kBlock, 0.0f);
    ParallelBlocks(RunContext(num_threads), kCount, kBlock, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        partial[begin / kBlock] += std::sin(static_cast<float>(i));
      }
    });
    float total = 0;
    for (const float p : partial) total += p;
    return total;
  };
  const float expected = sum(1);
  for (int repeat = 0; repeat < 5; ++repeat) {
    EXPECT_EQ(sum(2), expected);
    EXPECT_EQ(sum(7), expected);
  }
}

TEST(ParallelBlocks, UsesSeveralThreads) {
  std::set<std::thread::id> threads;
  std::mutex mutex;
  std::atomic<int> arrived = 0;
  ParallelBlocks(RunContext(2), 2, 1, [&](size_t, size_t) {
    ++arrived;
    // Waits for the other thread, but not for ever.
    for (int i = 0; i < 20000 && arrived < 2; ++i) {
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    const std::lock_guard<std::mutex> lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(threads.size(), 2u);
}

TEST(ParallelBlocks, RethrowsTheErrorOfABody) {
  for (const int num_threads : {1, 3}) {
    EXPECT_THROW(ParallelBlocks(RunContext(num_threads), 100, 1,
                                [](size_t begin, size_t) {
                                  if (begin == 57) throw InputError("f", "is bad", "");
                                }),
                 InputError);
  }
}

TEST(ParallelBlocks, StopsWhenCancelled) {
  for (const int num_threads : {1, 2}) {
    std::atomic<bool> cancel = false;
    std::atomic<int> count = 0;
    RunContext context(num_threads);
    context.cancel = &cancel;
    EXPECT_THROW(ParallelBlocks(context, 100000, 1,
                                [&](size_t, size_t) {
                                  if (++count == 10) cancel = true;
                                }),
                 CancelledError);
    EXPECT_GE(count, 10);
    EXPECT_LT(count, 100000);
    EXPECT_TRUE(context.Cancelled());
    EXPECT_THROW(context.ThrowIfCancelled(), CancelledError);
  }
}

TEST(ParallelBlocks, MayBeNested) {
  const RunContext context(3);
  std::atomic<int> count = 0;
  ParallelFor(context, 10, 1,
              [&](size_t) { ParallelFor(context, 20, 3, [&](size_t) { ++count; }); });
  EXPECT_EQ(count, 200);
}

TEST(ParallelBlocks, BlockOfNothingIsAMistake) {
  EXPECT_THROW(ParallelBlocks(RunContext(1), 10, 0, [](size_t, size_t) {}), std::logic_error);
  EXPECT_THROW(RunContext(0), std::logic_error);
}

class Recorder : public ProgressSink {
 public:
  void Report(double fraction) override { fractions.push_back(fraction); }
  std::vector<double> fractions;
};

TEST(RunContext, PartsOfPartsReportTheirShare) {
  Recorder recorder;
  RunContext context(1);
  context.Report(0.5);  // nobody listens
  context.set_progress(&recorder);
  const RunContext second_half = context.Part(0.5, 1.0);
  second_half.Report(0.5);
  second_half.Part(0.5, 1.0).Report(0.0);
  second_half.Part(0.5, 1.0).Report(2.0);
  context.Report(-1.0);
  EXPECT_EQ(recorder.fractions, (std::vector<double>{0.75, 0.75, 1.0, 0.0}));
}

TEST(RunContext, DefaultsAreUsable) {
  const RunContext context;
  EXPECT_GE(context.num_threads(), 1);
  EXPECT_GT(context.memory_budget_bytes, size_t{1} << 20);
  EXPECT_FALSE(context.Cancelled());
}

}  // namespace
}  // namespace lsmvs
