#pragma once

#include <cstddef>

namespace lsmvs {

// Bytes that this process could still take without swapping: what the kernel reports as available,
// cut by the limit of the process' control group if there is one.
size_t AvailableMemoryBytes();

// Highest resident size of this process since its start or the last ResetPeakResidentBytes().
size_t PeakResidentBytes();
void ResetPeakResidentBytes();

// From now on, what is freed of blocks of 2 MiB and more (images, maps, meshes) goes back to the
// system at once, instead of lying between smaller blocks until the end. For programs, at their
// start; does nothing where the C library has no such setting.
void ReturnLargeBlocksWhenFreed();

}  // namespace lsmvs
