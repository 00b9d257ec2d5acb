#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace lsmvs {

// Bytes that this process could still take without swapping: what the kernel reports as available,
// cut by the limit of the process' control group if there is one.
size_t AvailableMemoryBytes();

// Resident size of this process at present.
size_t ResidentBytes();
// Highest resident size of this process since its start: what `/usr/bin/time -v` shows. Nothing in
// this program resets it.
size_t PeakResidentBytes();

// The highest resident size of this process during the life of the object. A thread looks every 10
// ms; where the mark of the whole process rose meanwhile, the mark is the answer, exactly.
class PeakMemoryWatch {
 public:
  PeakMemoryWatch();
  ~PeakMemoryWatch();
  PeakMemoryWatch(const PeakMemoryWatch&) = delete;
  PeakMemoryWatch& operator=(const PeakMemoryWatch&) = delete;

  // From the start until now.
  size_t PeakBytes() const;
  // Resident size when the watch began.
  size_t bytes_before() const { return bytes_before_; }

 private:
  struct Sampler;

  const size_t mark_before_, bytes_before_;
  std::unique_ptr<Sampler> sampler_;
};

// From now on, what is freed of blocks of 2 MiB and more (images, maps, meshes) goes back to the
// system at once, instead of lying between smaller blocks until the end. For programs, at their
// start; does nothing where the C library has no such setting.
void ReturnLargeBlocksWhenFreed();

// Gives the pages back to the system that the C library holds for blocks that were freed. Between
// stages, so that one does not pay for what the one before needed. Takes milliseconds.
void ReturnFreedMemory();

// "1.5 GB", "20 MB": 1 GB = 10^9 bytes, 1 MB = 10^6, rounded up to whole megabytes.
std::string FormatBytes(size_t num_bytes);

}  // namespace lsmvs
