#pragma once

#include <filesystem>
#include <memory>

#include "lsmvs/util/shared_loop.h"

namespace lsmvs {

// The side of the process that is helped: waits for helpers on a port of its own, and shares its
// loops with those that are there. Says in `address_file` how to reach it, with a token that only
// readers of that file know. Where nobody can come (no network), it works alone.
class HelperLeader : public LoopHelpers {
 public:
  explicit HelperLeader(std::filesystem::path address_file);
  ~HelperLeader() override;  // helpers end, too

  void Run(const SharedLoop& loop, const RunContext& context) override;
  // Of all loops so far, those that helpers have computed.
  size_t num_items_by_helpers() const;
  // That are there now.
  size_t num_helpers() const;

 private:
  class Network;
  std::unique_ptr<Network> network_;
};

// The side of a helper: connects to the process that wrote `address_file`, and computes for it with
// the context's threads until that process ends or lets go. Returns how many items it computed.
// `is_over` tells, while it waits for the file, that nobody needs help any more; it waits a minute
// at most. Throws what the worker throws, and CancelledError.
size_t HelpLeader(const std::filesystem::path& address_file, const std::function<bool()>& is_over,
                  LoopWorker* worker, const RunContext& context);

}  // namespace lsmvs
