#include "lsmvs/util/duration_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lsmvs {

std::string FormatSeconds(double seconds) {
  const auto whole = static_cast<long>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

}  // namespace lsmvs
