// Memory of OpenCascade's objects in a process that reads files: a tenth of its time goes into malloc, since
// it asks for millions of small zeroed blocks, and glibc's calloc is slow at that.
//
// Loaded with RTLD_GLOBAL before OpenCascade (heap.py), these four functions stand in for those of its
// library TKernel, as a symbol found first does (ld.so(8)). What is freed is kept for blocks of the same
// size, and nothing is given back: the process ends with its file.
//
// Blocks of up to kLargest bytes lie in pages of one size each, in a range of addresses of their own, by
// which a block is told from one of malloc. Each thread has free lists of its own.

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>

namespace {

constexpr std::size_t kGrain = 16;     // bytes; sizes are its multiples, as malloc aligns
constexpr std::size_t kLargest = 512;  // bytes
constexpr std::size_t kPage = std::size_t{1} << 16;
constexpr std::size_t kStep = std::size_t{1} << 21;   // by which the range grows: a huge page
constexpr std::size_t kRange = std::size_t{1} << 36;  // addresses set aside; they cost nothing

struct Free {
  Free* next;
};

struct Size {
  Free* free = nullptr;
  char* fresh = nullptr;  // never used, so zero; up to end
  char* end = nullptr;
};

thread_local Size sizes[kLargest / kGrain + 1];  // by bytes / kGrain

// The range, shared by all threads. Where it cannot be had, or is used up, malloc serves.
std::mutex growing;
std::atomic<char*> range{nullptr};
std::size_t used = 0, writable = 0;  // bytes
bool refused = false;
std::uint8_t size_of_page[kRange / kPage];  // in kGrain

bool reserve() {
  if (refused) return false;
  void* found = mmap(nullptr, kRange + kStep, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  refused = found == MAP_FAILED;
  if (refused) return false;
  const auto address = reinterpret_cast<std::uintptr_t>(found);
  range = reinterpret_cast<char*>((address + kStep - 1) / kStep * kStep);
  return true;
}

// A zeroed page for blocks of that many grains; null where there is none.
char* new_page(std::size_t grains) {
  const std::lock_guard lock(growing);
  if ((range == nullptr && !reserve()) || used + kPage > kRange) return nullptr;
  char* const first = range;
  if (used == writable) {
    if (mprotect(first + writable, kStep, PROT_READ | PROT_WRITE) != 0) return nullptr;
    madvise(first + writable, kStep, MADV_HUGEPAGE);
    writable += kStep;
  }
  char* page = first + used;
  size_of_page[used / kPage] = static_cast<std::uint8_t>(grains);
  used += kPage;
  return page;
}

bool is_ours(const void* block) {
  const char* const first = range.load(std::memory_order_relaxed);
  return first != nullptr &&
         reinterpret_cast<std::uintptr_t>(block) - reinterpret_cast<std::uintptr_t>(first) < kRange;
}

std::size_t grains_of(const void* block) {
  const char* const first = range.load(std::memory_order_relaxed);
  return size_of_page[static_cast<std::size_t>(static_cast<const char*>(block) - first) / kPage];
}

void* checked(void* block) {
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

void* allocate(std::size_t bytes, bool zero) {
  const std::size_t grains = std::max<std::size_t>(1, (bytes + kGrain - 1) / kGrain);
  if (bytes <= kLargest) {
    Size& size = sizes[grains];
    if (Free* block = size.free) {
      size.free = block->next;
      if (zero) std::memset(block, 0, grains * kGrain);
      return block;
    }
    if (size.fresh == size.end && (size.fresh = new_page(grains)) != nullptr)
      size.end = size.fresh + kPage / (grains * kGrain) * (grains * kGrain);
    if (size.fresh != nullptr) {
      char* block = size.fresh;
      size.fresh += grains * kGrain;
      return block;
    }
    size.end = nullptr;
  }
  return checked(zero ? std::calloc(1, bytes) : std::malloc(bytes));
}

void release(void* block) {
  if (!is_ours(block)) return std::free(block);
  Size& size = sizes[grains_of(block)];
  size.free = new (block) Free{size.free};
}

}  // namespace

// Declared as in OpenCascade's Standard.hxx, where it is a class.
class __attribute__((visibility("default"))) Standard {
 public:
  static void* Allocate(std::size_t bytes);
  static void* AllocateOptimal(std::size_t bytes);
  static void* Reallocate(void* block, std::size_t bytes);
  static void Free(void* block);
};

// Zeroed, as OpenCascade's own.
void* Standard::Allocate(std::size_t bytes) { return allocate(bytes, true); }

void* Standard::AllocateOptimal(std::size_t bytes) { return allocate(bytes, false); }

void* Standard::Reallocate(void* block, std::size_t bytes) {
  if (block == nullptr) return allocate(bytes, true);
  if (!is_ours(block)) return checked(std::realloc(block, std::max<std::size_t>(1, bytes)));
  const std::size_t had = grains_of(block) * kGrain;
  if (bytes <= had) return block;
  void* moved = allocate(bytes, false);
  std::memcpy(moved, block, had);
  release(block);
  return moved;
}

void Standard::Free(void* block) { release(block); }
