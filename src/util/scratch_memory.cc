#include "lsmvs/util/scratch_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/periodic_thread.h"
#include "lsmvs/util/unnamed_file.h"

namespace lsmvs {

namespace internal {

ScratchRange scratch_range;
std::atomic<bool> scratch_is_on = false;

namespace {

constexpr size_t kChunk = 2 << 20;  // a huge page on most machines
// Address space, which costs nothing until it is used: the most, and the least where it is limited.
constexpr size_t kMaxRangeBytes = size_t{1} << 43, kMinRangeBytes = size_t{1} << 34;

bool scratch_new_is_linked = false;

// Where a chunk is, and which accesses do not fault.
enum class ChunkState : uint8_t {
  kNone,       // of no block
  kUntouched,  // zero
  kOnDisk,
  kClean,        // in memory, as on disk; readable
  kDirty,        // in memory; writable
  kLeavesClean,  // in memory, but the next in turn to leave unless it is touched; not accessible
  kLeavesDirty,
};

// Inside of a signal handler nothing can be thrown: one line, and the end.
[[noreturn]] void Die(const char* what) {
  constexpr const char* kStart = "error: scratch memory: ";
  const char* reason = std::strerror(errno);
  for (const char* text : {kStart, what, ": ", reason, "\n"}) {
    if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) break;
  }
  ::_exit(static_cast<int>(ExitCode::kFileSystem));
}

// Reads or writes the whole chunk.
template <class Call>
void Transfer(const Call& call, const char* what) {
  for (size_t done = 0; done < kChunk;) {
    const ssize_t count = call(done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) Die(what);
    done += static_cast<size_t>(count);
  }
}

// The chunks of the range and the file behind them: chunk i lies at the same offset in both.
//
// Faults of several threads are handled one after the other. The handler never touches the range
// but through system calls, and takes no lock that code which touches the range can hold.
class Pager {
 public:
  explicit Pager(const std::filesystem::path& folder)
      : folder_(folder), file_(OpenUnnamedFile(folder)) {
    states_ = static_cast<ChunkState*>(MapAnonymous(NumChunks(), PROT_READ | PROT_WRITE));
    spare_range_ = static_cast<std::byte*>(MapAnonymous(2 * kChunk, PROT_NONE));
    const size_t misaligned = reinterpret_cast<uintptr_t>(spare_range_) % kChunk;
    spare_ = spare_range_ + (misaligned == 0 ? 0 : kChunk - misaligned);
    MakeSpare();
  }
  ~Pager() {
    ::munmap(states_, NumChunks());
    ::munmap(spare_range_, 2 * kChunk);
    ::close(file_);
  }

  void SetLimit(size_t max_resident_bytes) {
    const std::lock_guard lock(mutex_);
    max_resident_bytes_ = max_resident_bytes;
    // What the process holds beside the chunks.
    const size_t resident = ResidentBytes();
    least_other_bytes_ = resident - std::min(resident, ring_.size() * kChunk);
    MeasureLimit();
  }

  // Where the rest of the process has grown, chunks make way.
  void Adapt() {
    const std::lock_guard lock(mutex_);
    MeasureLimit();
    KeepAtMost(max_chunks_);
  }

  void* Allocate(size_t num_bytes) {
    const size_t size = RoundUp(num_bytes);
    const std::lock_guard lock(mutex_);
    const size_t offset = FindGap(size);
    TakeSpace(offset, size);
    blocks_.emplace(offset, Block{size, size});
    in_use_ += size;
    peak_ = std::max(peak_.load(), in_use_.load());
    std::fill_n(states_ + offset / kChunk, size / kChunk, ChunkState::kUntouched);
    return scratch_range.begin + offset;
  }

  void Free(void* block) noexcept {
    const std::lock_guard lock(mutex_);
    const auto found =
        blocks_.find(static_cast<size_t>(static_cast<std::byte*>(block) - scratch_range.begin));
    const size_t offset = found->first;
    const Block block_of = found->second;
    blocks_.erase(found);
    in_use_ -= block_of.taken;
    Drop(offset, block_of.size, ChunkState::kNone);
  }

  void FreeTail(const void* block, size_t used_bytes) noexcept {
    const std::lock_guard lock(mutex_);
    const auto offset =
        static_cast<size_t>(static_cast<const std::byte*>(block) - scratch_range.begin);
    const auto found = blocks_.find(offset);
    if (found == blocks_.end()) return;
    const size_t used = RoundUp(used_bytes);
    if (used >= found->second.taken) return;
    in_use_ -= found->second.taken - used;
    found->second.taken = used;
    Drop(offset + used, found->second.size - used, ChunkState::kUntouched);
  }

  // False if the address belongs to no block.
  bool HandleFault(const void* address) {
    const int saved_errno = errno;
    const auto chunk = static_cast<uint32_t>(
        static_cast<size_t>(static_cast<const std::byte*>(address) - scratch_range.begin) / kChunk);
    const std::lock_guard lock(mutex_);
    const bool known = MakeAccessible(chunk);
    errno = saved_errno;
    return known;
  }

  size_t max_bytes() const { return max_chunks_ * kChunk; }
  uint64_t in_use() const { return in_use_; }
  uint64_t peak() const { return peak_; }
  uint64_t num_read() const { return num_read_; }
  uint64_t num_written() const { return num_written_; }

 private:
  static void* MapAnonymous(size_t size, int protection) {
    void* memory =
        ::mmap(nullptr, size, protection, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    return memory;
  }

  static size_t RangeBytes() {
    return static_cast<size_t>(scratch_range.end - scratch_range.begin);
  }
  static size_t NumChunks() { return RangeBytes() / kChunk; }
  static std::byte* AddressOf(uint32_t chunk) { return scratch_range.begin + chunk * kChunk; }
  static off_t OffsetOf(uint32_t chunk) { return static_cast<off_t>(chunk * kChunk); }

  static void Protect(uint32_t chunk, int protection) {
    if (::mprotect(AddressOf(chunk), kChunk, protection) != 0) Die("cannot protect memory");
  }

  static size_t RoundUp(size_t num_bytes) { return (num_bytes + kChunk - 1) / kChunk * kChunk; }

  // Forgets what the chunks hold.
  void Drop(size_t offset, size_t size, ChunkState state) noexcept {
    Unmap(offset, size);
    std::fill_n(states_ + offset / kChunk, size / kChunk, state);
    const size_t first = offset / kChunk, end = (offset + size) / kChunk;
    std::erase_if(ring_, [&](uint32_t c) { return c >= first && c < end; });
    GiveSpaceBack(offset, size);
  }

  static void Unmap(size_t offset, size_t size) {
    constexpr int kFlags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED | MAP_NORESERVE;
    if (::mmap(scratch_range.begin + offset, size, PROT_NONE, kFlags, -1, 0) == MAP_FAILED) {
      Die("cannot give memory back");
    }
  }

  bool MakeAccessible(uint32_t chunk) {
    ChunkState& state = states_[chunk];
    switch (state) {
      case ChunkState::kNone:
        return false;
      case ChunkState::kUntouched:
        MakeRoom();
        ::madvise(AddressOf(chunk), kChunk, MADV_HUGEPAGE);
        Protect(chunk, PROT_READ | PROT_WRITE);
        state = ChunkState::kDirty;
        ring_.push_back(chunk);
        break;
      case ChunkState::kOnDisk:
        MakeRoom();
        Load(chunk);
        state = ChunkState::kClean;
        ring_.push_back(chunk);
        break;
      case ChunkState::kClean:  // somebody writes
      case ChunkState::kLeavesDirty:
        Protect(chunk, PROT_READ | PROT_WRITE);
        state = ChunkState::kDirty;
        break;
      case ChunkState::kLeavesClean:
        Protect(chunk, PROT_READ);
        state = ChunkState::kClean;
        break;
      case ChunkState::kDirty:  // another thread was faster
        break;
    }
    return true;
  }

  // For one more chunk.
  void MakeRoom() {
    constexpr uint64_t kMeasureEach = 64;
    if (++num_made_room_ % kMeasureEach == 0) MeasureLimit();
    KeepAtMost(max_chunks_ - 1);
  }

  // Lets chunks leave, those that were not touched for a round first.
  void KeepAtMost(size_t num_chunks) {
    while (ring_.size() > num_chunks) {
      if (hand_ >= ring_.size()) hand_ = 0;
      const uint32_t chunk = ring_[hand_];
      ChunkState& state = states_[chunk];
      if (state == ChunkState::kClean || state == ChunkState::kDirty) {
        Protect(chunk, PROT_NONE);
        state = state == ChunkState::kClean ? ChunkState::kLeavesClean : ChunkState::kLeavesDirty;
        ++hand_;
        continue;
      }
      if (state == ChunkState::kLeavesDirty) Store(chunk);
      Empty(chunk);
      state = ChunkState::kOnDisk;
      ring_[hand_] = ring_.back();
      ring_.pop_back();
    }
  }

  // How many chunks may be in memory: what the limit leaves beside the rest of the process.
  void MeasureLimit() {
    constexpr size_t kSlack = 16 << 20, kLeastChunks = 16;
    const size_t resident = ResidentBytes(), chunks = ring_.size() * kChunk;
    const size_t other =
        std::max(least_other_bytes_, resident - std::min(resident, chunks)) + kSlack;
    const size_t left = max_resident_bytes_ - std::min(max_resident_bytes_, other);
    max_chunks_ = std::max(kLeastChunks, left / kChunk);
  }

  void Store(uint32_t chunk) {
    Protect(chunk, PROT_READ);  // nobody writes while it is read
    Transfer(
        [&](size_t done) {
          return ::pwrite(file_, AddressOf(chunk) + done, kChunk - done,
                          OffsetOf(chunk) + static_cast<off_t>(done));
        },
        "cannot write");
    Protect(chunk, PROT_NONE);
    ++num_written_;
  }

  // Takes the pages away. Those of one chunk are kept for the next that is read, for which the
  // kernel would have to clear new ones.
  void Empty(uint32_t chunk) {
#ifdef MREMAP_DONTUNMAP
    if (!spare_has_pages_ &&
        ::mremap(AddressOf(chunk), kChunk, kChunk, MREMAP_MAYMOVE | MREMAP_FIXED | MREMAP_DONTUNMAP,
                 spare_) != MAP_FAILED) {
      if (::mprotect(spare_, kChunk, PROT_READ | PROT_WRITE) != 0) Die("cannot protect memory");
      spare_has_pages_ = true;
      return;
    }
#endif
    Unmap(chunk * kChunk, kChunk);
  }

  // Read elsewhere and moved to its place, so that no other thread sees it half read.
  void Load(uint32_t chunk) {
    Transfer(
        [&](size_t done) {
          return ::pread(file_, spare_ + done, kChunk - done,
                         OffsetOf(chunk) + static_cast<off_t>(done));
        },
        "cannot read");
    if (::mprotect(spare_, kChunk, PROT_READ) != 0) Die("cannot protect memory");
    if (::mremap(spare_, kChunk, kChunk, MREMAP_MAYMOVE | MREMAP_FIXED, AddressOf(chunk)) ==
        MAP_FAILED) {
      Die("cannot move memory");
    }
    MakeSpare();
    ++num_read_;
  }

  void MakeSpare() {
    constexpr int kFlags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED | MAP_NORESERVE;
    if (::mmap(spare_, kChunk, PROT_READ | PROT_WRITE, kFlags, -1, 0) == MAP_FAILED) {
      Die("cannot take memory");
    }
    ::madvise(spare_, kChunk, MADV_HUGEPAGE);
    spare_has_pages_ = false;
  }

  // The first gap that is large enough.
  size_t FindGap(size_t size) const {
    size_t begin = 0;
    for (const auto& [offset, block] : blocks_) {
      if (offset - begin >= size) return begin;
      begin = offset + block.size;
    }
    if (begin + size > RangeBytes()) throw std::bad_alloc();
    return begin;
  }

  void TakeSpace(size_t offset, size_t size) {
    const int error =
        ::posix_fallocate(file_, static_cast<off_t>(offset), static_cast<off_t>(size));
    if (error == 0) return;
    GiveSpaceBack(offset, size);
    throw ScratchFullError(fmt::format(
        "{}: scratch memory holds {} there and needs {} more ({}); free space, or name another "
        "folder by --scratch_path",
        folder_.string(), FormatBytes(in_use_.load()), FormatBytes(size), std::strerror(error)));
  }

  void GiveSpaceBack(size_t offset, size_t size) noexcept {
#ifdef FALLOC_FL_PUNCH_HOLE
    // Where it fails, the space stays taken until the end.
    [[maybe_unused]] const int ignored =
        ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset),
                    static_cast<off_t>(size));
#endif
  }

  const std::filesystem::path folder_;
  const int file_;
  std::mutex mutex_;
  struct Block {
    size_t size = 0;
    size_t taken = 0;  // on disk: the size, or less where the tail was given back
  };
  std::map<size_t, Block> blocks_;  // by offset
  ChunkState* states_;
  std::byte *spare_range_, *spare_;  // a chunk outside of the range, to read into
  bool spare_has_pages_ = false;
  std::vector<uint32_t> ring_;  // chunks in memory
  size_t hand_ = 0;             // where in ring_ the search for one to leave goes on
  size_t max_resident_bytes_ = 0, least_other_bytes_ = 0;
  std::atomic<size_t> max_chunks_ = 0;
  uint64_t num_made_room_ = 0;
  std::atomic<uint64_t> in_use_ = 0, peak_ = 0, num_read_ = 0, num_written_ = 0;
};

// Never destroyed: blocks may be freed until the very end.
std::unique_ptr<Pager>& ThePager() {
  static auto* pager = new std::unique_ptr<Pager>;
  return *pager;
}

// Lets the pager adapt again and again.
std::unique_ptr<PeriodicThread>& TheWatch() {
  static auto* watch = new std::unique_ptr<PeriodicThread>;
  return *watch;
}

struct sigaction previous_action;

// Accesses to the range are made possible and go on; anything else is what it was before.
void OnFault(int number, siginfo_t* info, void* context) {
  if (scratch_range.Holds(info->si_addr) && ThePager()->HandleFault(info->si_addr)) return;
  if ((previous_action.sa_flags & SA_SIGINFO) != 0) {
    previous_action.sa_sigaction(number, info, context);
  } else if (previous_action.sa_handler != SIG_DFL && previous_action.sa_handler != SIG_IGN) {
    previous_action.sa_handler(number);
  } else {
    ::signal(SIGSEGV, SIG_DFL);
    // An access is repeated when this returns, and ends the process; a signal that was sent is not.
    if (info->si_code <= 0) ::raise(number);
  }
}

void TakeRange() {
  if (scratch_range.begin != nullptr) return;
  constexpr int kFlags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;
  size_t size = kMaxRangeBytes;
  void* range = MAP_FAILED;
  while ((range = ::mmap(nullptr, size + kChunk, PROT_NONE, kFlags, -1, 0)) == MAP_FAILED) {
    if (size <= kMinRangeBytes) throw std::bad_alloc();
    size /= 2;
  }
  const auto begin = (reinterpret_cast<uintptr_t>(range) + kChunk - 1) / kChunk * kChunk;
  scratch_range.begin = reinterpret_cast<std::byte*>(begin);
  scratch_range.end = scratch_range.begin + size;
  struct sigaction action = {};
  action.sa_sigaction = OnFault;
  action.sa_flags = SA_SIGINFO | SA_NODEFER | SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGSEGV, &action, &previous_action);
}

}  // namespace

void* AllocateScratch(size_t num_bytes) { return ThePager()->Allocate(num_bytes); }
void FreeScratch(void* block) noexcept { ThePager()->Free(block); }
void DeclareScratchNew() noexcept { scratch_new_is_linked = true; }

}  // namespace internal

ScratchMemory::ScratchMemory(const ScratchMemoryOptions& options) {
  LSMVS_CHECK(!IsOn());
  if (!IsAvailable()) return;
  internal::TakeRange();
  auto& pager = internal::ThePager();
  if (pager == nullptr || pager->in_use() == 0) {
    pager = std::make_unique<internal::Pager>(options.folder);
  }
  pager->SetLimit(options.max_resident_bytes);
  internal::TheWatch() = std::make_unique<PeriodicThread>(std::chrono::milliseconds(10),
                                                          [] { internal::ThePager()->Adapt(); });
  internal::scratch_is_on = true;
}

ScratchMemory::~ScratchMemory() {
  internal::scratch_is_on = false;
  internal::TheWatch().reset();
}

bool ScratchMemory::IsAvailable() { return internal::scratch_new_is_linked; }
bool ScratchMemory::IsOn() { return internal::scratch_is_on; }

namespace {

template <class Get>
uint64_t FromPager(const Get& get) {
  const auto& pager = internal::ThePager();
  return pager == nullptr ? 0 : get(*pager);
}

}  // namespace

size_t ScratchMemory::MaxBytesInMemory() {
  return FromPager([](const internal::Pager& pager) { return pager.max_bytes(); });
}
uint64_t ScratchMemory::BytesInUse() {
  return FromPager([](const internal::Pager& pager) { return pager.in_use(); });
}
uint64_t ScratchMemory::PeakBytes() {
  return FromPager([](const internal::Pager& pager) { return pager.peak(); });
}
void ScratchMemory::GiveBackTail(const void* block, size_t used_bytes) {
  if (!internal::scratch_range.Holds(block)) return;
  internal::ThePager()->FreeTail(block, used_bytes);
}
uint64_t ScratchMemory::BytesWritten() {
  return FromPager(
      [](const internal::Pager& pager) { return pager.num_written() * internal::kChunk; });
}
uint64_t ScratchMemory::BytesRead() {
  return FromPager(
      [](const internal::Pager& pager) { return pager.num_read() * internal::kChunk; });
}

}  // namespace lsmvs
