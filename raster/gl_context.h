// A context of OpenGL that draws into memory of its own, and the libraries that make one.
#pragma once

#include <memory>
#include <string>

namespace trimray::raster {

class GlContext {
 public:
  virtual ~GlContext() = default;
  // For the calling thread; no other thread may hold it. Throws Error.
  virtual void make_current() = 0;
  virtual void release() = 0;
  virtual void* function(const char* name) const = 0;
};

// A library that makes contexts; one a process, never unloaded. Not thread-safe.
class GlPlatform {
 public:
  virtual ~GlPlatform() = default;
  // OpenGL 4.5, core profile. Throws Error.
  virtual std::unique_ptr<GlContext> make_context() = 0;
  // Whether contexts can be made in a child of a process that made some: there are no threads or devices that
  // the child would miss.
  virtual bool survives_fork() const = 0;
};

// Load the library; throw Error with the reason where that fails.
std::unique_ptr<GlPlatform> open_osmesa();
std::unique_ptr<GlPlatform> open_egl();

// While one lives, Mesa's rasterizer on the processor is set up without threads of its own (unless the
// environment says otherwise): those would be missing in a child of this process, which then hangs, and the
// pictures that we draw at the same time keep all cores busy.
class NoRasterThreads {
 public:
  NoRasterThreads();
  ~NoRasterThreads();
  NoRasterThreads(const NoRasterThreads&) = delete;
  NoRasterThreads& operator=(const NoRasterThreads&) = delete;
  // Whether that is how it is now.
  static bool in_force();

 private:
  bool ours_ = false;
};

}  // namespace trimray::raster
