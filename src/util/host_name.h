#pragma once

#include <string>

namespace lsmvs {

// Of this machine, as it calls itself.
std::string HostName();

}  // namespace lsmvs
