#include "lsmvs/cli/progress_display.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "lsmvs/cli/common_options.h"
#include "lsmvs/util/memory.h"

namespace lsmvs {

namespace {

constexpr double kBarInterval = 0.1;   // seconds between redraws on a terminal
constexpr double kLineInterval = 5.0;  // seconds between lines elsewhere
constexpr double kMinSecondsForEta = 1.0;
constexpr int kBarWidth = 30;

std::string Bar(double fraction) {
  const int filled = static_cast<int>(fraction * kBarWidth);
  return std::string(static_cast<size_t>(filled), '#') +
         std::string(static_cast<size_t>(kBarWidth - filled), '.');
}

}  // namespace

ProgressDisplay::ProgressDisplay(std::FILE* stream)
    : stream_(stream), is_terminal_(::isatty(::fileno(stream)) == 1) {}

void ProgressDisplay::Begin(const std::string& title, double done_before) {
  const std::lock_guard lock(mutex_);
  title_ = title;
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
  fraction_ = std::clamp(std::max(fraction, fraction_), 0.0, 1.0);
  const std::chrono::duration<double> since = Clock::now() - last_drawn_;
  if (since.count() >= (is_terminal_ ? kBarInterval : kLineInterval)) Draw(fraction_);
}

double ProgressDisplay::Seconds() const {
  return std::chrono::duration<double>(Clock::now() - begin_).count();
}

std::string ProgressDisplay::StatusText(double fraction) const {
  const double elapsed = Seconds();
  std::string text = fmt::format("{:3.0f} %, {} so far", 100 * fraction, FormatSeconds(elapsed));
  const double done = fraction - done_before_;
  if (done > 0.01 && elapsed >= kMinSecondsForEta) {
    text += fmt::format(", about {} left", FormatSeconds(elapsed * (1 - fraction) / done));
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

void ProgressDisplay::End(const std::string& note) {
  const std::lock_guard lock(mutex_);
  if (!active_) return;
  ClearBar();
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

}  // namespace lsmvs
