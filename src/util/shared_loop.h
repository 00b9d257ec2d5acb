#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// A loop whose items other processes can compute, too: helpers, on other machines. An item must
// depend on the loop's states alone, so that it is the same to the byte wherever it is computed.

// What an item depends on, by a key that the loop's maker chooses.
struct LoopState {
  int key = 0;
  std::shared_ptr<const std::string> bytes;
};

struct SharedLoop {
  int kind = 0;  // which loop of the task: helpers are told
  size_t count = 0;
  // Items that one process takes in a row, at most. What they need in common is made once for a
  // row; their results may have to wait for those of items before them.
  size_t longest_row = 8;
  // Makes what helpers must be sent; not called where there are none. A state that has the bytes of
  // the last one with its key is not sent again.
  std::function<std::vector<LoopState>()> states;
  // Computes an item here. It must then call `is_first`, and keep the result only if that is true:
  // else somebody else has computed the item meanwhile. Called by several threads at once;
  // must not run a parallel loop itself, in which it might wait for another item of this one.
  std::function<void(size_t item, const std::function<bool()>& is_first)> compute;
  // Keeps what a helper has computed. Called by another thread than those of `compute`.
  std::function<void(size_t item, std::string_view result)> keep;
};

// The processes that help this one.
class LoopHelpers {
 public:
  virtual ~LoopHelpers() = default;
  // Runs the loop with whoever is there. Throws what `compute` and `keep` throw, and
  // CancelledError. A helper that is lost or slow costs time, never the result.
  virtual void Run(const SharedLoop& loop, const RunContext& context) = 0;
};

// What runs in a helper.
class LoopWorker {
 public:
  virtual ~LoopWorker() = default;
  // No item is at work meanwhile.
  virtual void SetState(int key, std::string bytes) = 0;
  // Before the first item of a loop, once its states are set.
  virtual void Begin(int /*kind*/) {}
  // Called by several threads at once.
  virtual std::string Compute(int kind, size_t item) = 0;
};

// Runs a loop with the context's helpers, or here alone where it has none. Items are begun in their
// order.
void RunSharedLoop(const SharedLoop& loop, const RunContext& context);

}  // namespace lsmvs
