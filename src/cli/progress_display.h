#pragma once

#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What a plan says of a phase.
struct PlannedSeconds {
  double phase = 0;  // of the phase, without what was done before; 0: unknown
  double after = 0;  // of the phases to come
};

// Shows how far the present phase is and when it will end: a bar that is redrawn on a terminal,
// otherwise a line every few seconds. Writes to the error stream, so that results on stdout stay
// clean. Thread-safe.
//
// The time left starts from the plan, which is for an idle machine, and goes over to what the run
// itself shows: the share of the phase that is done and the time it took. How much slower than
// planned the run has been so far holds for the phases to come.
class ProgressDisplay : public ProgressSink {
 public:
  // `stream` outlives the display. Whether it is a terminal is found out.
  explicit ProgressDisplay(std::FILE* stream = stderr);

  // Starts a phase, called `title` in what is shown. Progress starts anew at 0; `done_before` of it
  // needed no work (resumed), so that the time left is reckoned from the rest.
  void Begin(const std::string& title, double done_before = 0, PlannedSeconds planned = {});
  void Report(double fraction) override;
  // Prints a line, between what is shown of the progress.
  void Note(const std::string& note);
  // Ends the phase and says how long it took; `note` follows ("2.3 M points").
  void End(const std::string& note = "");
  // Ends the phase without a word of success (an error follows).
  void Abandon();

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
