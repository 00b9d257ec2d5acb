#pragma once

#include <string>

namespace lsmvs {

// "lsmvs 0.1.0".
std::string VersionLine();

}  // namespace lsmvs
