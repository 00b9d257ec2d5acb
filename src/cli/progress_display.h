#pragma once

#include <chrono>
#include <cstdio>
#include <mutex>
#include <string>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Shows how far the present phase is and when it will end: a bar that is redrawn on a terminal,
// otherwise a line every few seconds. Writes to the error stream, so that results on stdout stay
// clean. Thread-safe.
class ProgressDisplay : public ProgressSink {
 public:
  // `stream` outlives the display. Whether it is a terminal is found out.
  explicit ProgressDisplay(std::FILE* stream = stderr);

  // Starts a phase, called `title` in what is shown. Progress starts anew at 0; `done_before` of it
  // needed no work (resumed), so that the time left is reckoned from the rest.
  void Begin(const std::string& title, double done_before = 0);
  void Report(double fraction) override;
  // Ends the phase and says how long it took; `note` follows ("2.3 M points").
  void End(const std::string& note = "");
  // Ends the phase without a word of success (an error follows).
  void Abandon();

  // Seconds since Begin().
  double Seconds() const;

 private:
  using Clock = std::chrono::steady_clock;

  void Draw(double fraction);
  void ClearBar();
  std::string StatusText(double fraction) const;

  std::FILE* stream_;
  bool is_terminal_;
  mutable std::mutex mutex_;
  std::string title_;
  bool active_ = false, bar_drawn_ = false;
  double done_before_ = 0, fraction_ = 0;
  Clock::time_point begin_, last_drawn_;
};

}  // namespace lsmvs
