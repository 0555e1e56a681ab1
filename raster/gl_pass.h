// The raster pass: one program, one framebuffer, one context.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "raster/gl_api.h"
#include "raster/gl_context.h"
#include "raster/projection.h"

namespace trimray::raster {

// Used by one thread at a time, between make_current() and release().
class GlPass {
 public:
  // Makes the context current for a moment. Throws Error where the context is not fit for it.
  explicit GlPass(std::unique_ptr<GlContext> context);

  void make_current() { context_->make_current(); }
  void release() { context_->release(); }

  int largest_px() const { return largest_px_; }
  const std::string& version() const { return version_; }

  // Draws a band's triangles, in their order, and reads the band back. id, uv: of the whole picture, row by
  // row, picture_width pixels a row. Throws Error where OpenGL fails, out of memory included.
  void draw(std::span<const VisibleTriangles> triangles, const Window& window, int band, SeedProcess process,
            int picture_width, std::uint32_t* id, float* uv);

 private:
  gl::Uint make_program(SeedProcess process);
  void make_targets(int width, int height);
  void check(const char* what);

  std::unique_ptr<GlContext> context_;
  gl::Api gl_;
  std::string version_;
  int largest_px_ = 0;
  gl::Uint program_[2] = {};  // by SeedProcess
  gl::Uint vertices_ = 0, indices_ = 0, framebuffer_ = 0, id_ = 0, uv_ = 0, depth_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace trimray::raster
