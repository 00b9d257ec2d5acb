#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace lsmvs {

class LoopHelpers;

// Receives the progress of the work; called from any thread, at most a few hundred times a stage.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  // `fraction` in [0,1] never decreases within one stage.
  virtual void Report(double fraction) = 0;
};

// What an algorithm needs to know of its surroundings. Passed last, by const reference; cheap to
// copy. Results never depend on num_threads.
class RunContext {
 public:
  // All cores, no cancel, no progress, most of the free memory, seed 0.
  RunContext();
  // `num_threads` >= 1.
  explicit RunContext(int num_threads);

  int num_threads() const { return num_threads_; }

  uint64_t seed = 0;
  // Bytes that this work may take beyond what is in use already.
  size_t memory_budget_bytes;
  // Set by a signal handler or another thread to stop; may be null.
  const std::atomic<bool>* cancel = nullptr;

  // Processes on other machines that take part in loops (shared_loop.h); null: none.
  LoopHelpers* helpers = nullptr;

  bool Cancelled() const { return cancel != nullptr && cancel->load(std::memory_order_relaxed); }
  // Throws CancelledError.
  void ThrowIfCancelled() const;

  // Reports progress of this context's part of the work; `fraction` in [0,1].
  void Report(double fraction) const;
  void set_progress(ProgressSink* sink) { progress_ = sink; }
  ProgressSink* progress() const { return progress_; }
  // A context whose [0,1] is [begin,end] of this one's: for the phases of an algorithm.
  RunContext Part(double begin, double end) const;

 private:
  friend void ParallelBlocks(const RunContext&, size_t, size_t,
                             const std::function<void(size_t, size_t)>&);
  struct Arena;

  int num_threads_;
  ProgressSink* progress_ = nullptr;
  double part_begin_ = 0.0, part_end_ = 1.0;
  std::shared_ptr<Arena> arena_;
};

// Calls body(begin, end) on the blocks [0,block), [block,2*block), ... of [0,count), in parallel
// and in any order. The blocks do not depend on the number of threads, so that a caller who keeps
// one partial result a block and adds them up in block order gets the same bytes for any number of
// threads. Polls for cancel between blocks (throws CancelledError); rethrows the first exception of
// a body. `block` >= 1.
void ParallelBlocks(const RunContext& context, size_t count, size_t block,
                    const std::function<void(size_t begin, size_t end)>& body);

// Calls body(i) for each i of [0,count), `block` at a time.
template <class Body>
void ParallelFor(const RunContext& context, size_t count, size_t block, const Body& body) {
  ParallelBlocks(context, count, block, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace lsmvs
