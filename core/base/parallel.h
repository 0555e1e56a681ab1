// Loops over all cores. The result of a loop body must not depend on the thread that runs it:
// the same bytes with 1 and N threads.
#pragma once

#include <cstddef>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace trimray {

// Calls body(begin, end) for disjoint ranges that cover [0, count), each at most grain long when
// grain > 1. threads = 0: all cores.
template <typename Body>
void parallel_ranges(std::size_t count, std::size_t grain, int threads, const Body& body) {
  if (count == 0) return;
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, grain),
        [&](const tbb::blocked_range<std::size_t>& r) { body(r.begin(), r.end()); },
        tbb::simple_partitioner());
  });
}

// A T for each thread that asks for it, made when it first does.
template <typename T>
class PerThread {
 public:
  T& local() { return values_.local(); }

 private:
  tbb::enumerable_thread_specific<T> values_;
};

}  // namespace trimray
