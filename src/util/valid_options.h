#pragma once

#include <string>

#include "lsmvs/util/error.h"

namespace lsmvs {

// The one way in which entry functions refuse options: throws UsageError with what Check() says.
template <class Options>
void RequireValid(const Options& options) {
  if (std::string error; !options.Check(&error)) throw UsageError(error);
}

}  // namespace lsmvs
