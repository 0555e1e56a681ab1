// OpenCascade's memory from oneTBB's allocator, in a process that reads files. It asks for millions of small
// zeroed blocks, and glibc's calloc is a seventh of the time then. OpenCascade can be built so (mmgr_type
// TBB); OCP's is not.
//
// Loaded with RTLD_GLOBAL before OpenCascade (heap.py), these four functions stand in for those of its
// library TKernel, as a symbol found first does (ld.so(8)).

#include <tbb/scalable_allocator.h>

#include <algorithm>
#include <cstddef>
#include <new>

namespace {

std::size_t some(std::size_t bytes) { return std::max<std::size_t>(1, bytes); }

void* checked(void* block) {
  if (block == nullptr) throw std::bad_alloc();
  return block;
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
void* Standard::Allocate(std::size_t bytes) { return checked(scalable_calloc(1, some(bytes))); }

void* Standard::AllocateOptimal(std::size_t bytes) { return checked(scalable_malloc(some(bytes))); }

void* Standard::Reallocate(void* block, std::size_t bytes) {
  return block == nullptr ? Allocate(bytes) : checked(scalable_realloc(block, some(bytes)));
}

void Standard::Free(void* block) { scalable_free(block); }
