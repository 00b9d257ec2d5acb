#include "lsmvs/util/memory.h"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include "lsmvs/util/periodic_thread.h"

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

size_t ResidentBytes() {
  std::ifstream file("/proc/self/statm");
  size_t total = 0, resident = 0;
  if (!(file >> total >> resident)) return 0;
  return resident * static_cast<size_t>(::sysconf(_SC_PAGESIZE));
}

size_t PeakResidentBytes() { return ReadKilobyteLine("/proc/self/status", "VmHWM:"); }

struct PeakMemoryWatch::Sampler {
  explicit Sampler(size_t bytes) : highest(bytes) {}
  void Look() { highest = std::max(highest.load(), ResidentBytes()); }

  std::atomic<size_t> highest;
  PeriodicThread thread{std::chrono::milliseconds(10), [this] { Look(); }};  // last: it uses it
};

PeakMemoryWatch::PeakMemoryWatch()
    : mark_before_(PeakResidentBytes()),
      bytes_before_(ResidentBytes()),
      sampler_(std::make_unique<Sampler>(bytes_before_)) {}

PeakMemoryWatch::~PeakMemoryWatch() = default;

size_t PeakMemoryWatch::PeakBytes() const {
  const size_t mark = PeakResidentBytes();
  return mark > mark_before_ ? mark : std::max(sampler_->highest.load(), ResidentBytes());
}

void ReturnLargeBlocksWhenFreed() {
#ifdef M_MMAP_THRESHOLD
  mallopt(M_MMAP_THRESHOLD, 2 << 20);
#endif
}

void ReturnFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::string FormatBytes(size_t num_bytes) {
  constexpr double kMegabyte = 1e6, kGigabyte = 1e9;
  const double bytes = static_cast<double>(num_bytes);
  if (bytes >= 10 * kGigabyte) return fmt::format("{:.0f} GB", bytes / kGigabyte);
  if (bytes >= kGigabyte) return fmt::format("{:.1f} GB", bytes / kGigabyte);
  return fmt::format("{:.0f} MB", std::ceil(bytes / kMegabyte));
}

}  // namespace lsmvs
