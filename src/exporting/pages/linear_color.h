#pragma once

#include <cmath>
#include <cstdint>

namespace lsmvs {

// Linear light in 16 bits of an sRGB level, as glTF wants vertex colours.
inline uint16_t LinearShort(uint8_t srgb) {
  const double s = srgb / 255.0;
  const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<uint16_t>(std::lround(65535 * linear));
}

}  // namespace lsmvs
