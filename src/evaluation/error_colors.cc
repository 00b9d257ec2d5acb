#include "lsmvs/evaluation/error_colors.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lsmvs {

namespace {

// Viridis at steps of 1/10.
constexpr std::array<std::array<double, 3>, 11> kViridis = {{{68, 1, 84},
                                                             {72, 36, 117},
                                                             {65, 68, 135},
                                                             {53, 95, 141},
                                                             {42, 120, 142},
                                                             {33, 145, 140},
                                                             {34, 168, 132},
                                                             {68, 191, 112},
                                                             {122, 209, 81},
                                                             {189, 223, 38},
                                                             {253, 231, 37}}};

const Color kNeutral(150, 150, 150);

}  // namespace

Color ErrorColor(double value) {
  if (std::isnan(value)) return kNeutral;
  const double place = std::clamp(value, 0.0, 1.0) * (kViridis.size() - 1);
  const size_t low = std::min(static_cast<size_t>(place), kViridis.size() - 2);
  const double part = place - static_cast<double>(low);
  Color color;
  for (size_t k = 0; k < 3; ++k) {
    const double mixed = kViridis[low][k] + part * (kViridis[low + 1][k] - kViridis[low][k]);
    color[static_cast<int>(k)] = static_cast<uint8_t>(std::lround(mixed));
  }
  return color;
}

std::vector<Color> ErrorColors(const std::vector<double>& values, double max_value) {
  std::vector<Color> colors;
  colors.reserve(values.size());
  for (const double value : values) colors.push_back(ErrorColor(value / max_value));
  return colors;
}

}  // namespace lsmvs
