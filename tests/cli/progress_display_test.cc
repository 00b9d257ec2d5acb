#include "lsmvs/cli/progress_display.h"

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
