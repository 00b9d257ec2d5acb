#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace lsmvs {

// Wall time since it was made, or since the last lap; seconds.
class Stopwatch {
 public:
  double Seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  // As Seconds(); the next lap begins.
  double Lap() {
    const double seconds = Seconds();
    begin_ = Clock::now();
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::time_point begin_ = Clock::now();
};

// Wall time of each phase of a stage, in the order in which they first ended.
using PhaseSeconds = std::vector<std::pair<std::string, double>>;

// Adds the wall time of its life to a phase.
class PhaseTimer {
 public:
  PhaseTimer(std::string phase, PhaseSeconds* seconds)
      : phase_(std::move(phase)), seconds_(*seconds) {}
  ~PhaseTimer() {
    const auto known = std::find_if(seconds_.begin(), seconds_.end(),
                                    [&](const auto& entry) { return entry.first == phase_; });
    if (known != seconds_.end()) {
      known->second += stopwatch_.Seconds();
    } else {
      seconds_.emplace_back(phase_, stopwatch_.Seconds());
    }
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  const std::string phase_;
  PhaseSeconds& seconds_;
  const Stopwatch stopwatch_;
};

}  // namespace lsmvs
