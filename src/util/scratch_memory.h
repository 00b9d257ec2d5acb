#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <new>
#include <string>

namespace lsmvs {

// Memory that lies partly in a file, for work that is larger than the machine's memory.
//
// While it is on, blocks of kMinScratchBlock bytes and more that the program's operator new hands
// out come from a range of address space of their own, in chunks of 2 MiB. As many chunks are in
// memory as keeps the resident size of the process below a limit; of the others, those touched
// longest ago go to a file, and come back when they are touched again. Nothing else changes: what
// is computed has the same bytes. How fast it is depends on the order in which data are touched:
// work along a space-filling curve moves each chunk a few times only. A chunk that comes back from
// the system's file cache costs about 0.5 ms.
//
// The file has no name: it is gone when the process ends, however it ends. Its space is taken when
// a block is made, so a full disk is met there, as ScratchFullError, and given back when the block
// is freed.
//
// Limits: a system call must not be given an address within such a block (it would report EFAULT
// where a chunk is not in memory): files are read and written through small buffers. Only programs
// that link lsmvs_scratch_new (the replaced operator new) have it.
inline constexpr size_t kMinScratchBlock = 4 << 20;

struct ScratchMemoryOptions {
  std::filesystem::path folder;
  size_t max_resident_bytes = 0;  // of the whole process
};

// The disk that holds the file is full. Thrown by operator new.
class ScratchFullError : public std::bad_alloc {
 public:
  explicit ScratchFullError(std::string message) : message_(std::move(message)) {}
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  std::string message_;
};

// On from construction to destruction, one at a time. Blocks that live longer stay where they are
// until they are freed.
class ScratchMemory {
 public:
  // Throws FileSystemError if the folder cannot hold such a file, std::logic_error if there is one
  // already.
  explicit ScratchMemory(const ScratchMemoryOptions& options);
  ~ScratchMemory();
  ScratchMemory(const ScratchMemory&) = delete;
  ScratchMemory& operator=(const ScratchMemory&) = delete;

  // Whether this program links lsmvs_scratch_new; without, a ScratchMemory does nothing.
  static bool IsAvailable();
  static bool IsOn();
  // Of blocks, that the limit leaves room for.
  static size_t MaxBytesInMemory();

  // What all blocks take, on disk: now, and at most since the start of the process.
  static uint64_t BytesInUse();
  static uint64_t PeakBytes();
  // Gives back what a block that starts at `block` takes behind its first `used_bytes`: for arrays
  // that turn out smaller than what was reserved. It may be used later all the same; its bytes are
  // then zero, and its space is taken when it goes to the file. Nothing happens for other blocks.
  static void GiveBackTail(const void* block, size_t used_bytes);

  // Moved to and from the file since the start of the process.
  static uint64_t BytesWritten();
  static uint64_t BytesRead();
};

namespace internal {

// For operator new and delete.
struct ScratchRange {
  std::byte* begin = nullptr;
  std::byte* end = nullptr;
  bool Holds(const void* p) const { return p >= begin && p < end; }
};
extern ScratchRange scratch_range;
extern std::atomic<bool> scratch_is_on;
void* AllocateScratch(size_t num_bytes);
void FreeScratch(void* block) noexcept;
void DeclareScratchNew() noexcept;

}  // namespace internal

}  // namespace lsmvs
