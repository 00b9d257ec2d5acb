#pragma once

#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>

#include "lsmvs/program/console.h"

namespace lsmvs {

// Shows how far the present phase is and when it will end: a bar that is redrawn on a terminal,
// otherwise a line every few seconds. Writes to the error stream, so that results on stdout stay
// clean. Thread-safe.
//
// The time left starts from the plan, which is for an idle machine, and goes over to what the run
// itself shows: the share of the phase that is done and the time it took. How much slower than
// planned the run has been so far holds for the phases to come.
class ProgressDisplay : public Console {
 public:
  // `stream` outlives the display. Whether it is a terminal is found out.
  explicit ProgressDisplay(std::FILE* stream = stderr);

  void Begin(const std::string& title, double done_before = 0,
             PlannedSeconds planned = {}) override;
  void Report(double fraction) override;
  void Note(const std::string& note) override;
  void End(const std::string& note = "") override;
  void Abandon() override;
  void Print(const std::string& text) override;
  // Asks only if standard input and the error stream are a terminal.
  std::optional<std::string> Ask(const std::string& question) override;

  // Seconds since Begin().
  double Seconds() const;

  // Seconds that are left of the phase at `now` seconds since its begin, `fraction` having been
  // done `elapsed` seconds after it; nothing while there is nothing to reckon from.
  std::optional<double> SecondsLeft(double fraction, double elapsed, double now) const;
  // How many times as long as planned the run takes, from all that is done.
  double Slowdown(double fraction, double elapsed) const;

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
  double seconds_at_fraction_ = 0;  // since Begin(), when fraction_ was reached
  PlannedSeconds planned_;
  double past_planned_ = 0, past_seconds_ = 0;  // of the phases with a plan that have ended
  Clock::time_point begin_, last_drawn_;
};

}  // namespace lsmvs
