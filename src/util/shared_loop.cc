#include "lsmvs/util/shared_loop.h"

#include <atomic>

namespace lsmvs {

void RunSharedLoop(const SharedLoop& loop, const RunContext& context) {
  if (context.helpers != nullptr) return context.helpers->Run(loop, context);
  // Handed out in order, whatever block a thread takes: no result waits long for those before it.
  std::atomic<size_t> next = 0;
  ParallelFor(context, loop.count, 1, [&](size_t) { loop.compute(next++, [] { return true; }); });
}

}  // namespace lsmvs
