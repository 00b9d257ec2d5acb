// Operator new of the programs: large blocks lie in the scratch file while a ScratchMemory is on.
// Linked by programs only, so that the library leaves the allocator of whoever uses it alone.

#include <cstdlib>
#include <new>

#include "lsmvs/util/scratch_memory.h"

namespace {

const bool kDeclared = [] {
  lsmvs::internal::DeclareScratchNew();
  return true;
}();

bool IsForScratch(std::size_t num_bytes) {
  return num_bytes >= lsmvs::kMinScratchBlock && lsmvs::internal::scratch_is_on;
}

void* Allocate(std::size_t num_bytes, std::size_t alignment) {
  if (IsForScratch(num_bytes)) return lsmvs::internal::AllocateScratch(num_bytes);
  if (num_bytes == 0) num_bytes = 1;
  while (true) {
    void* block = nullptr;
    if (alignment <= alignof(std::max_align_t)) {
      block = std::malloc(num_bytes);
    } else if (::posix_memalign(&block, alignment, num_bytes) != 0) {
      block = nullptr;
    }
    if (block != nullptr) return block;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void Free(void* block) noexcept {
  if (lsmvs::internal::scratch_range.Holds(block)) {
    lsmvs::internal::FreeScratch(block);
  } else {
    std::free(block);
  }
}

}  // namespace

// The other forms (arrays, nothrow, sized) are defined by the standard library in terms of these.
void* operator new(std::size_t num_bytes) { return Allocate(num_bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t num_bytes, std::align_val_t alignment) {
  return Allocate(num_bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept { Free(block); }
void operator delete(void* block, std::align_val_t) noexcept { Free(block); }
void operator delete(void* block, std::size_t) noexcept { Free(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { Free(block); }
