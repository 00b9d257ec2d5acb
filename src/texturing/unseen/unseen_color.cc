#include "lsmvs/texturing/unseen/unseen_color.h"

#include <cstdio>

namespace lsmvs {

std::optional<Color> ParseUnseenColor(const std::string& text) {
  int r = 0, g = 0, b = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d,%d%c", &r, &g, &b, &rest) != 3) return std::nullopt;
  for (const int value : {r, g, b}) {
    if (value < 0 || value > 255) return std::nullopt;
  }
  return Color(static_cast<uint8_t>(r), static_cast<uint8_t>(g), static_cast<uint8_t>(b));
}

}  // namespace lsmvs
