#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

// Checks of what the *programmer* promised. A failed check throws std::logic_error with both
// values; bad input of a user is reported by lsmvs/util/error.h instead.

namespace lsmvs::internal {
[[noreturn]] inline void FailCheck(const char* file, int line, const std::string& what) {
  throw std::logic_error(fmt::format("{}:{}: check failed: {}", file, line, what));
}
}  // namespace lsmvs::internal

#define LSMVS_CHECK(condition)                                      \
  do {                                                              \
    if (!(condition)) [[unlikely]]                                  \
      ::lsmvs::internal::FailCheck(__FILE__, __LINE__, #condition); \
  } while (false)

#define LSMVS_CHECK_OP(a, op, b)                                                                  \
  do {                                                                                            \
    const auto& check_a = (a);                                                                    \
    const auto& check_b = (b);                                                                    \
    if (!(check_a op check_b)) [[unlikely]]                                                       \
      ::lsmvs::internal::FailCheck(                                                               \
          __FILE__, __LINE__, fmt::format("{} " #op " {} ({} vs {})", #a, #b, check_a, check_b)); \
  } while (false)

#define LSMVS_CHECK_EQ(a, b) LSMVS_CHECK_OP(a, ==, b)
#define LSMVS_CHECK_NE(a, b) LSMVS_CHECK_OP(a, !=, b)
#define LSMVS_CHECK_LT(a, b) LSMVS_CHECK_OP(a, <, b)
#define LSMVS_CHECK_LE(a, b) LSMVS_CHECK_OP(a, <=, b)
#define LSMVS_CHECK_GT(a, b) LSMVS_CHECK_OP(a, >, b)
#define LSMVS_CHECK_GE(a, b) LSMVS_CHECK_OP(a, >=, b)
