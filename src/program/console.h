#pragma once

#include <optional>
#include <string>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What a plan says of a phase.
struct PlannedSeconds {
  double phase = 0;  // of the phase, without what was done before; 0: unknown
  double after = 0;  // of the phases to come
};

// What a command shows and asks while it works. Report() may be called by any thread.
class Console : public ProgressSink {
 public:
  // Starts a phase, called `title` in what is shown. Progress starts anew at 0; `done_before` of it
  // needed no work (resumed), so that the time left is reckoned from the rest.
  virtual void Begin(const std::string& title, double done_before = 0,
                     PlannedSeconds planned = {}) = 0;
  // Ends the phase and says how long it took; `note` follows ("2.3 M points").
  virtual void End(const std::string& note = "") = 0;
  // Ends the phase without a word of success (an error follows).
  virtual void Abandon() = 0;
  // Shows a line between what is shown of the progress.
  virtual void Note(const std::string& note) = 0;
  // Prints a result, to standard output.
  virtual void Print(const std::string& text) = 0;
  // The line that the user answers with; nothing where nobody can be asked.
  virtual std::optional<std::string> Ask(const std::string& question) = 0;
};

}  // namespace lsmvs
