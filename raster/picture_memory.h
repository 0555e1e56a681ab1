// Memory of pictures, used again once its last reader is done: fresh pages cost as much as the readback.
#pragma once

#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

namespace trimray::raster {

class PictureMemory : public std::enable_shared_from_this<PictureMemory> {
 public:
  ~PictureMemory() {
    for (const auto& [bytes, memory] : free_) std::free(memory);
  }

  // Aligned for any SIMD; what it holds is left from before. It outlives this object if need be.
  std::shared_ptr<void> take(std::size_t bytes) {
    bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    void* memory = nullptr;
    {
      const std::lock_guard lock(mutex_);
      for (std::size_t i = 0; i < free_.size() && !memory; ++i)
        if (free_[i].first == bytes) {
          memory = free_[i].second;
          free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    if (!memory) memory = std::aligned_alloc(kAlignment, bytes);
    if (!memory) throw std::bad_alloc();
    return {memory, [bytes, home = weak_from_this()](void* done) {
              if (const auto pool = home.lock())
                pool->give_back(bytes, done);
              else
                std::free(done);
            }};
  }

 private:
  static constexpr std::size_t kAlignment = 64, kMost = 4, kLargest = std::size_t{64} << 20;

  void give_back(std::size_t bytes, void* memory) {
    const std::lock_guard lock(mutex_);
    if (bytes > kLargest) {
      std::free(memory);
      return;
    }
    free_.insert(free_.begin(), {bytes, memory});
    if (free_.size() <= kMost) return;
    std::free(free_.back().second);
    free_.pop_back();
  }

  std::mutex mutex_;
  std::vector<std::pair<std::size_t, void*>> free_;  // the latest first
};

}  // namespace trimray::raster
