#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>

namespace lsmvs {

// Adds the wall time of its life to `(*seconds)[phase]`.
class PhaseTimer {
 public:
  PhaseTimer(std::string phase, std::map<std::string, double>* seconds)
      : phase_(std::move(phase)), seconds_(*seconds), begin_(Clock::now()) {}
  ~PhaseTimer() {
    seconds_[phase_] += std::chrono::duration<double>(Clock::now() - begin_).count();
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  std::string phase_;
  std::map<std::string, double>& seconds_;
  Clock::time_point begin_;
};

}  // namespace lsmvs
