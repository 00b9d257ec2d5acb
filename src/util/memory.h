#pragma once

#include <cstddef>

namespace lsmvs {

// Bytes that this process could still take without swapping: what the kernel reports as available,
// cut by the limit of the process' control group if there is one.
size_t AvailableMemoryBytes();

// Highest resident size of this process since its start or the last ResetPeakResidentBytes().
size_t PeakResidentBytes();
void ResetPeakResidentBytes();

}  // namespace lsmvs
