#include "lsmvs/program/terminal/signals.h"

#include <signal.h>
#include <unistd.h>

namespace lsmvs {

namespace {

std::atomic<bool> cancelled{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // usable in a signal handler

void OnStop(int) {
  cancelled.store(true);
  static constexpr char kMessage[] = "\nstopping; once more to stop at once\n";
  [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
}

}  // namespace

const std::atomic<bool>* InstallSignalHandlers() {
  struct sigaction action = {};
  action.sa_handler = OnStop;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
  return &cancelled;
}

}  // namespace lsmvs
