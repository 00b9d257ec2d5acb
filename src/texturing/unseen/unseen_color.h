#pragma once

#include <optional>
#include <string>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// "r,g,b" in 0 .. 255; nothing if it is not that.
std::optional<Color> ParseUnseenColor(const std::string& text);

}  // namespace lsmvs
