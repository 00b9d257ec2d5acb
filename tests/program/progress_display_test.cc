#include "lsmvs/program/terminal/progress_display.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace lsmvs {
namespace {

using testing::HasSubstr;

// What is printed to something that is not a terminal.
class Printed {
 public:
  Printed() : file_(std::tmpfile()) {}
  ~Printed() { std::fclose(file_); }
  Printed(const Printed&) = delete;
  Printed& operator=(const Printed&) = delete;

  std::FILE* file() const { return file_; }
  std::string text() const {
    std::string text(static_cast<size_t>(std::ftell(file_)), '\0');
    std::rewind(file_);
    EXPECT_EQ(std::fread(text.data(), 1, text.size(), file_), text.size());
    return text;
  }

 private:
  std::FILE* file_;
};

TEST(ProgressDisplay, OffATerminalSaysBeginAndEndAndFewLinesBetween) {
  const Printed printed;
  ProgressDisplay display(printed.file());
  display.Begin("fusion");
  for (int i = 0; i <= 10000; ++i) display.Report(i / 10000.0);
  display.End("5 points");
  const std::string text = printed.text();
  EXPECT_THAT(text, HasSubstr("fusion: started\n"));
  EXPECT_THAT(text, HasSubstr("fusion: done in 1 s; 5 points\n"));
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_EQ(text.find('\033'), std::string::npos);
}

// A phase that runs three times slower than planned.
TEST(ProgressDisplay, TimeLeftGoesFromThePlanToWhatTheRunShows) {
  const Printed printed;
  ProgressDisplay display(printed.file());
  display.Begin("stereo", 0, {100, 50});
  EXPECT_NEAR(display.SecondsLeft(0, 0, 0).value(), 100, 1e-6);
  EXPECT_NEAR(display.SecondsLeft(0, 0, 20).value(), 80, 1e-6);  // nothing was seen yet
  const double at_half = display.SecondsLeft(0.5, 150, 150).value();
  EXPECT_GT(at_half, 120);
  EXPECT_LT(at_half, 150);
  EXPECT_NEAR(display.SecondsLeft(0.9, 270, 270).value(), 30, 5);
  EXPECT_EQ(display.SecondsLeft(1, 300, 300).value(), 0);
  EXPECT_NEAR(display.Slowdown(0.9, 270), 3, 0.1);
  // A step that takes long never counts down to nothing.
  EXPECT_GT(display.SecondsLeft(0.5, 150, 10000).value(), 60);
  display.End();
}

TEST(ProgressDisplay, WhatWasDoneBeforeDoesNotCount) {
  const Printed printed;
  ProgressDisplay display(printed.file());
  display.Begin("stereo", 0.5, {100, 0});
  EXPECT_NEAR(display.SecondsLeft(0.5, 0, 0).value(), 100, 1e-6);
  EXPECT_NEAR(display.SecondsLeft(0.75, 50, 50).value(), 50, 1e-6);
  display.End();
  display.Begin("undistortion");  // nobody planned it
  EXPECT_FALSE(display.SecondsLeft(0, 0, 10).has_value());
  EXPECT_NEAR(display.SecondsLeft(0.25, 10, 10).value(), 30, 1e-6);
}

TEST(ProgressDisplay, AfterAnErrorSaysNothingOfSuccess) {
  const Printed printed;
  ProgressDisplay display(printed.file());
  display.Begin("fusion");
  display.Abandon();
  display.End("5 points");
  display.Report(0.5);
  EXPECT_EQ(printed.text(), "fusion: started\n");
}

}  // namespace
}  // namespace lsmvs
