#pragma once

#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// A colour for a value of [0, 1], dark blue over green to yellow: perceptually uniform, and
// readable for people who do not tell red from green (viridis, by S. van der Walt and N. Smith).
// NaN gives a neutral grey.
Color ErrorColor(double value);

// ErrorColor(value / max_value), a value each.
std::vector<Color> ErrorColors(const std::vector<double>& values, double max_value);

}  // namespace lsmvs
