#pragma once

#include <string_view>

namespace lsmvs {

// The page without its data, as bundled from src/report/web at build time. Empty if the build left
// it out.
std::string_view PageTemplate();

}  // namespace lsmvs
