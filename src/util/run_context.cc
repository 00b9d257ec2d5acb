#include "lsmvs/util/run_context.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <thread>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {

struct RunContext::Arena {
  explicit Arena(int num_threads)
      // By default TBB never starts more workers than there are cores, whatever an arena asks for.
      : limit(tbb::global_control::max_allowed_parallelism,
              static_cast<size_t>(std::max<int>(
                  num_threads, static_cast<int>(std::thread::hardware_concurrency())))),
        arena(num_threads) {}
  tbb::global_control limit;
  tbb::task_arena arena;
};

RunContext::RunContext()
    : RunContext(static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))) {}

RunContext::RunContext(int num_threads)
    : memory_budget_bytes(AvailableMemoryBytes() / 10 * 9), num_threads_(num_threads) {
  LSMVS_CHECK_GE(num_threads, 1);
  arena_ = std::make_shared<Arena>(num_threads);
}

void RunContext::ThrowIfCancelled() const {
  if (Cancelled()) throw CancelledError();
}

void RunContext::Report(double fraction) const {
  if (progress_ == nullptr) return;
  const double clamped = std::clamp(fraction, 0.0, 1.0);
  progress_->Report(part_begin_ + clamped * (part_end_ - part_begin_));
}

RunContext RunContext::Part(double begin, double end) const {
  RunContext part = *this;
  part.part_begin_ = part_begin_ + begin * (part_end_ - part_begin_);
  part.part_end_ = part_begin_ + end * (part_end_ - part_begin_);
  return part;
}

void ParallelBlocks(const RunContext& context, size_t count, size_t block,
                    const std::function<void(size_t, size_t)>& body) {
  LSMVS_CHECK_GE(block, size_t{1});
  const size_t num_blocks = (count + block - 1) / block;
  const auto run = [&](size_t b) {
    context.ThrowIfCancelled();
    body(b * block, std::min(count, (b + 1) * block));
  };
  if (context.num_threads() == 1 || num_blocks <= 1) {
    for (size_t b = 0; b < num_blocks; ++b) run(b);
    return;
  }
  context.arena_->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, num_blocks, 1),
        [&](const tbb::blocked_range<size_t>& range) {
          for (size_t b = range.begin(); b != range.end(); ++b) run(b);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace lsmvs
