#include "lsmvs/util/memory.h"

#include <malloc.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace lsmvs {

namespace {

// Value in bytes of a "Name:  123 kB" line, or 0 if there is none.
size_t ReadKilobyteLine(const char* path, const std::string& name) {
  std::ifstream file(path);
  std::string key;
  while (file >> key) {
    size_t kilobytes = 0;
    if (key == name && file >> kilobytes) return kilobytes * 1024;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

// Reads one number; "max" or no file mean no limit.
size_t ReadLimit(const char* path) {
  std::ifstream file(path);
  size_t value = 0;
  return file >> value ? value : std::numeric_limits<size_t>::max();
}

}  // namespace

size_t AvailableMemoryBytes() {
  const size_t available = ReadKilobyteLine("/proc/meminfo", "MemAvailable:");
  const size_t limit = ReadLimit("/sys/fs/cgroup/memory.max");
  if (limit == std::numeric_limits<size_t>::max()) return available;
  const size_t used = ReadLimit("/sys/fs/cgroup/memory.current");
  return std::min(available, limit > used ? limit - used : 0);
}

size_t PeakResidentBytes() { return ReadKilobyteLine("/proc/self/status", "VmHWM:"); }

void ReturnLargeBlocksWhenFreed() {
#ifdef M_MMAP_THRESHOLD
  mallopt(M_MMAP_THRESHOLD, 2 << 20);
#endif
}

void ResetPeakResidentBytes() { std::ofstream("/proc/self/clear_refs") << "5"; }

}  // namespace lsmvs
