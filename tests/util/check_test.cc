#include "lsmvs/util/check.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace lsmvs {
namespace {

TEST(Check, PassesSilentlyAndEvaluatesOnce) {
  int count = 0;
  const auto next = [&] { return ++count; };
  LSMVS_CHECK(next() == 1);
  LSMVS_CHECK_EQ(next(), 2);
  LSMVS_CHECK_LE(next(), 3);
  EXPECT_EQ(count, 3);
}

TEST(Check, FailureShowsBothValuesAndThePlace) {
  try {
    LSMVS_CHECK_LT(2 + 3, 4);
    FAIL() << "no error";
  } catch (const std::logic_error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("5 vs 4"), std::string::npos) << message;
    EXPECT_NE(message.find("check_test.cc"), std::string::npos) << message;
  }
  EXPECT_THROW(LSMVS_CHECK(false), std::logic_error);
  EXPECT_THROW(LSMVS_CHECK_EQ(1, 2), std::logic_error);
  EXPECT_THROW(LSMVS_CHECK_NE(1, 1), std::logic_error);
  EXPECT_THROW(LSMVS_CHECK_GT(1, 1), std::logic_error);
  EXPECT_THROW(LSMVS_CHECK_GE(1, 2), std::logic_error);
}

}  // namespace
}  // namespace lsmvs
