#include "lsmvs/util/phase_timer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace lsmvs {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Ge;
using testing::Pair;

void Spend(const char* phase, int milliseconds, PhaseSeconds* seconds) {
  const PhaseTimer timer(phase, seconds);
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

TEST(PhaseTimerTest, AddsUpWhatAPhaseTookEachTime) {
  PhaseSeconds seconds;
  Spend("search", 4, &seconds);
  Spend("fill", 1, &seconds);
  Spend("search", 4, &seconds);
  EXPECT_THAT(seconds, ElementsAre(Pair("search", Ge(0.008)), Pair("fill", Ge(0.001))));
}

TEST(StopwatchTest, LapsBeginWhereTheLastOneEnded) {
  Stopwatch stopwatch;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_GE(stopwatch.Lap(), 0.02);
  EXPECT_LT(stopwatch.Seconds(), 0.02);
}

}  // namespace
}  // namespace lsmvs
