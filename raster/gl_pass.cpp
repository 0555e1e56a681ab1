#include "raster/gl_pass.h"

#include <algorithm>
#include <cstddef>

#include "core/base/error.h"

namespace trimray::raster {

namespace {

// Positions come in clip coordinates: they are projected in double precision on our side. The id is flat, as
// an attribute: gl_PrimitiveID costs 1.75 times the pass.
constexpr const char* kVertexShader = R"(#version 450 core
layout(location = 0) in vec4 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in uint id;
flat out uint vertex_id;
out vec2 vertex_uv;
void main() {
  gl_Position = position;
  vertex_id = id;
  vertex_uv = uv;
}
)";

constexpr const char* kFragmentShader[] = {R"(#version 450 core
flat in uint vertex_id;
layout(location = 0) out uint pixel_id;
void main() { pixel_id = vertex_id; }
)",
                                           R"(#version 450 core
flat in uint vertex_id;
in vec2 vertex_uv;
layout(location = 0) out uint pixel_id;
layout(location = 1) out vec2 pixel_uv;
void main() {
  pixel_id = vertex_id;
  pixel_uv = vertex_uv;
}
)"};

template <typename Parameter, typename Log>
void check_made(gl::Uint object, gl::Enum status, const Parameter& parameter, const Log& log,
                const char* what) {
  gl::Int done = 0;
  parameter(object, status, &done);
  if (done) return;
  char text[512] = {};
  log(object, sizeof text - 1, nullptr, text);
  throw Error(std::string("OpenGL cannot ") + what + ": " +
              std::string(text).substr(0, std::string(text).find('\n')));
}

}  // namespace

GlPass::GlPass(std::unique_ptr<GlContext> context) : context_(std::move(context)) {
  context_->make_current();
  struct Release {
    GlContext& context;
    ~Release() { context.release(); }
  } release{*context_};

  if (const char* missing = gl_.load([&](const char* name) { return context_->function(name); }))
    throw Error(std::string("OpenGL has no function ") + missing);
  const auto text = [&](gl::Enum name) {
    const auto* s = reinterpret_cast<const char*>(gl_.GetString(name));
    return std::string(s ? s : "?");
  };
  version_ = text(gl::kRenderer) + ", OpenGL " + text(gl::kVersion);
  gl::Int major = 0, minor = 0;
  gl_.GetIntegerv(gl::kMajorVersion, &major), gl_.GetIntegerv(gl::kMinorVersion, &minor);
  if (10 * major + minor < 45) throw Error("OpenGL 4.5 is needed; this is " + version_);
  gl_.GetIntegerv(gl::kMaxRenderbufferSize, &largest_px_);

  for (const SeedProcess process : {SeedProcess::kId, SeedProcess::kUv})
    program_[static_cast<int>(process)] = make_program(process);
  gl_.GenBuffers(1, &vertices_), gl_.GenBuffers(1, &indices_);
  gl::Uint layout = 0;
  gl_.GenVertexArrays(1, &layout);
  gl_.BindVertexArray(layout);
  gl_.BindBuffer(gl::kArrayBuffer, vertices_);
  gl_.BindBuffer(gl::kElementArrayBuffer, indices_);
  const auto at = [](std::size_t offset) { return reinterpret_cast<const void*>(offset); };
  constexpr gl::Sizei kStride = sizeof(ClipVertex);
  gl_.VertexAttribPointer(0, 4, gl::kFloat, 0, kStride, at(offsetof(ClipVertex, x)));
  gl_.VertexAttribPointer(1, 2, gl::kFloat, 0, kStride, at(offsetof(ClipVertex, u)));
  gl_.VertexAttribIPointer(2, 1, gl::kUnsignedInt, kStride, at(offsetof(ClipVertex, id)));
  for (gl::Uint k = 0; k < 3; ++k) gl_.EnableVertexAttribArray(k);

  gl_.GenFramebuffers(1, &framebuffer_);
  gl_.GenRenderbuffers(1, &id_), gl_.GenRenderbuffers(1, &uv_), gl_.GenRenderbuffers(1, &depth_);
  gl_.BindFramebuffer(gl::kFramebuffer, framebuffer_);
  gl_.Enable(gl::kDepthTest);
  gl_.Disable(gl::kDither);
  // Depth from 1 at the near plane to 0: floats are as fine far away as they are near.
  gl_.ClipControl(gl::kLowerLeft, gl::kZeroToOne);
  gl_.DepthFunc(gl::kGreater);
  gl_.PixelStorei(gl::kPackAlignment, 4);
  check("set up");
}

gl::Uint GlPass::make_program(SeedProcess process) {
  const gl::Uint program = gl_.CreateProgram();
  const auto add = [&](gl::Enum kind, const char* source) {
    const gl::Uint shader = gl_.CreateShader(kind);
    gl_.ShaderSource(shader, 1, &source, nullptr);
    gl_.CompileShader(shader);
    check_made(shader, gl::kCompileStatus, gl_.GetShaderiv, gl_.GetShaderInfoLog, "compile a shader");
    gl_.AttachShader(program, shader);
  };
  add(gl::kVertexShader, kVertexShader);
  add(gl::kFragmentShader, kFragmentShader[static_cast<int>(process)]);
  gl_.LinkProgram(program);
  check_made(program, gl::kLinkStatus, gl_.GetProgramiv, gl_.GetProgramInfoLog, "link a program");
  return program;
}

void GlPass::make_targets(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = height_ = 0;  // until it is done
  const auto attach = [&](gl::Uint target, gl::Enum format, gl::Enum point) {
    gl_.BindRenderbuffer(gl::kRenderbuffer, target);
    gl_.RenderbufferStorage(gl::kRenderbuffer, format, width, height);
    gl_.FramebufferRenderbuffer(gl::kFramebuffer, point, gl::kRenderbuffer, target);
  };
  attach(id_, gl::kR32ui, gl::kColorAttachment0);
  attach(uv_, gl::kRg32f, gl::kColorAttachment0 + 1);
  attach(depth_, gl::kDepth32f, gl::kDepthAttachment);
  check("make a picture");
  if (gl_.CheckFramebufferStatus(gl::kFramebuffer) != gl::kFramebufferComplete)
    throw Error("OpenGL cannot draw integers and floats into one picture");
  width_ = width, height_ = height;
}

void GlPass::check(const char* what) {
  const gl::Enum error = gl_.GetError();
  if (error == gl::kNoError) return;
  char number[16];
  std::snprintf(number, sizeof number, "0x%04x", error);
  throw Error(std::string("OpenGL cannot ") + what + ": error " + number);
}

void GlPass::draw(std::span<const VisibleTriangles> triangles, const Window& window, int band,
                  SeedProcess process, int picture_width, std::uint32_t* id, float* uv) {
  const bool with_uv = process == SeedProcess::kUv;
  const int rows = window.rows(band);
  make_targets(window.width, window.band_height);
  gl_.Viewport(0, -band * window.band_height, window.width, window.height);
  const gl::Enum targets[] = {gl::kColorAttachment0, gl::kColorAttachment0 + 1};
  gl_.DrawBuffers(with_uv ? 2 : 1, targets);
  constexpr gl::Uint kNothing[4] = {};
  constexpr float kFar[1] = {0.0f};
  gl_.ClearBufferuiv(gl::kColor, 0, kNothing);
  gl_.ClearBufferfv(gl::kDepth, 0, kFar);  // uv is left as it is: it means nothing where id is 0
  gl_.UseProgram(program_[static_cast<int>(process)]);
  for (const VisibleTriangles& t : triangles) {
    const std::vector<std::uint32_t>& indices = t.indices[static_cast<std::size_t>(band)];
    if (indices.empty()) continue;
    const auto bytes = [](const auto& v) { return static_cast<gl::Intptr>(v.size() * sizeof v[0]); };
    gl_.BufferData(gl::kArrayBuffer, bytes(t.vertices), t.vertices.data(), gl::kStreamDraw);
    gl_.BufferData(gl::kElementArrayBuffer, bytes(indices), indices.data(), gl::kStreamDraw);
    gl_.DrawElements(gl::kTriangles, static_cast<gl::Sizei>(indices.size()), gl::kUnsignedInt, nullptr);
    gl_.Flush();  // bins of a few thousand triangles stay in cache
  }

  // The formats are those of the targets: no conversion.
  const std::size_t first =
      static_cast<std::size_t>(window.y0 + band * window.band_height) * picture_width + window.x0;
  gl_.PixelStorei(gl::kPackRowLength, picture_width);
  gl_.ReadBuffer(targets[0]);
  gl_.ReadPixels(0, 0, window.width, rows, gl::kRedInteger, gl::kUnsignedInt, id + first);
  if (with_uv) {
    gl_.ReadBuffer(targets[1]);
    gl_.ReadPixels(0, 0, window.width, rows, gl::kRg, gl::kFloat, uv + 2 * first);
  }
  check("draw");
  // What few pictures need is not kept.
  constexpr std::int64_t kMostKept = 4 << 20;
  if (static_cast<std::int64_t>(width_) * height_ > kMostKept) make_targets(1, 1);
}

}  // namespace trimray::raster
