#include "lsmvs/program/terminal/progress_display.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "lsmvs/util/duration_text.h"

namespace lsmvs {

namespace {

constexpr double kBarInterval = 0.1;   // seconds between redraws on a terminal
constexpr double kLineInterval = 5.0;  // seconds between lines elsewhere
constexpr double kMinSecondsForEta = 1.0;
// The plan counts as much as what was seen of such a part of the phase, and as so many seconds of
// phases before.
constexpr double kPlanWeight = 0.15;
constexpr double kPlanSeconds = 3.0;
// Progress comes in steps: what has gone by since the last one counts down at most such a part.
constexpr double kMaxCountedDown = 0.5;
constexpr int kBarWidth = 30;

std::string Bar(double fraction) {
  const int filled = static_cast<int>(fraction * kBarWidth);
  return std::string(static_cast<size_t>(filled), '#') +
         std::string(static_cast<size_t>(kBarWidth - filled), '.');
}

}  // namespace

ProgressDisplay::ProgressDisplay(std::FILE* stream)
    : stream_(stream), is_terminal_(::isatty(::fileno(stream)) == 1) {}

void ProgressDisplay::Begin(const std::string& title, double done_before, PlannedSeconds planned) {
  const std::lock_guard lock(mutex_);
  title_ = title;
  planned_ = planned;
  seconds_at_fraction_ = 0;
  done_before_ = fraction_ = std::clamp(done_before, 0.0, 1.0);
  begin_ = last_drawn_ = Clock::now();
  active_ = true;
  if (is_terminal_) {
    Draw(fraction_);
  } else {
    fmt::print(stream_, "{}: started\n", title_);
    std::fflush(stream_);
  }
}

void ProgressDisplay::Report(double fraction) {
  const std::lock_guard lock(mutex_);
  if (!active_) return;
  const double clamped = std::clamp(fraction, 0.0, 1.0);
  if (clamped > fraction_) {
    fraction_ = clamped;
    seconds_at_fraction_ = Seconds();
  }
  const std::chrono::duration<double> since = Clock::now() - last_drawn_;
  if (since.count() >= (is_terminal_ ? kBarInterval : kLineInterval)) Draw(fraction_);
}

double ProgressDisplay::Seconds() const {
  return std::chrono::duration<double>(Clock::now() - begin_).count();
}

double ProgressDisplay::Slowdown(double fraction, double elapsed) const {
  const double part = (fraction - done_before_) / std::max(1e-9, 1 - done_before_);
  return (kPlanSeconds + past_seconds_ + (planned_.phase > 0 ? elapsed : 0)) /
         (kPlanSeconds + past_planned_ + part * planned_.phase);
}

std::optional<double> ProgressDisplay::SecondsLeft(double fraction, double elapsed,
                                                   double now) const {
  const double done = (fraction - done_before_) / std::max(1e-9, 1 - done_before_);
  if (planned_.phase <= 0 && (done <= 0.01 || now < kMinSecondsForEta)) return std::nullopt;
  const double past_slowdown = (kPlanSeconds + past_seconds_) / (kPlanSeconds + past_planned_);
  const double expected = planned_.phase * past_slowdown;
  const double weight = planned_.phase > 0 ? kPlanWeight : 0.0;
  const double left = (1 - done) * (weight * expected + elapsed) / (weight + done);
  return left - std::min(now - elapsed, kMaxCountedDown * left);
}

std::string ProgressDisplay::StatusText(double fraction) const {
  const double now = Seconds();
  std::string text = fmt::format("{:3.0f} %, {} so far", 100 * fraction, FormatSeconds(now));
  const std::optional<double> left = SecondsLeft(fraction, seconds_at_fraction_, now);
  if (!left) return text;
  text += fmt::format(", about {} left", FormatSeconds(*left));
  if (planned_.after > 0) {
    const double after = planned_.after * Slowdown(fraction, seconds_at_fraction_);
    text += fmt::format(", {} with what follows", FormatSeconds(*left + after));
  }
  return text;
}

void ProgressDisplay::Draw(double fraction) {
  last_drawn_ = Clock::now();
  if (is_terminal_) {
    fmt::print(stream_, "\r{:<20} [{}] {}\033[K", title_, Bar(fraction), StatusText(fraction));
    bar_drawn_ = true;
  } else {
    fmt::print(stream_, "{}: {}\n", title_, StatusText(fraction));
  }
  std::fflush(stream_);
}

void ProgressDisplay::ClearBar() {
  if (bar_drawn_) fmt::print(stream_, "\r\033[K");
  bar_drawn_ = false;
}

void ProgressDisplay::Note(const std::string& note) {
  const std::lock_guard lock(mutex_);
  ClearBar();
  fmt::print(stream_, "{}\n", note);
  std::fflush(stream_);
}

void ProgressDisplay::End(const std::string& note) {
  const std::lock_guard lock(mutex_);
  if (!active_) return;
  ClearBar();
  if (planned_.phase > 0) {
    past_planned_ += planned_.phase;
    past_seconds_ += Seconds();
  }
  fmt::print(stream_, "{}: done in {}{}{}\n", title_, FormatSeconds(Seconds()),
             note.empty() ? "" : "; ", note);
  std::fflush(stream_);
  active_ = false;
}

void ProgressDisplay::Abandon() {
  const std::lock_guard lock(mutex_);
  if (!active_) return;
  ClearBar();
  std::fflush(stream_);
  active_ = false;
}

void ProgressDisplay::Print(const std::string& text) {
  fmt::print("{}", text);
  std::fflush(stdout);
}

std::optional<std::string> ProgressDisplay::Ask(const std::string& question) {
  if (::isatty(STDIN_FILENO) != 1 || ::isatty(STDERR_FILENO) != 1) return std::nullopt;
  fmt::print(stderr, "{}", question);
  std::fflush(stderr);
  std::string answer;
  std::getline(std::cin, answer);
  return answer;
}

}  // namespace lsmvs
