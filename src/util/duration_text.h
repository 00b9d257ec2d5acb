#pragma once

#include <string>

namespace lsmvs {

// "42 s", "3:07 min", "2:05 h"; rounded up to whole seconds, of hours down to whole minutes.
std::string FormatSeconds(double seconds);

}  // namespace lsmvs
