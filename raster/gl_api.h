// The few functions and numbers of OpenGL 4.5 that the raster pass uses; all are asked from the context, none
// is linked.
#pragma once

#include <cstddef>
#include <cstdint>

namespace trimray::raster::gl {

using Enum = std::uint32_t;
using Uint = std::uint32_t;
using Int = std::int32_t;
using Sizei = std::int32_t;
using Bitfield = std::uint32_t;
using Boolean = std::uint8_t;
using Intptr = std::ptrdiff_t;

inline constexpr Enum kNoError = 0, kVendor = 0x1F00, kRenderer = 0x1F01, kVersion = 0x1F02,
                      kTriangles = 0x0004, kGreater = 0x0204, kDepthTest = 0x0B71, kUnsignedInt = 0x1405,
                      kFloat = 0x1406, kColor = 0x1800, kDepth = 0x1801, kRg = 0x8227, kRedInteger = 0x8D94,
                      kRg32f = 0x8230, kR32ui = 0x8236, kDepth32f = 0x8CAC, kPackAlignment = 0x0D05,
                      kPackRowLength = 0x0D02, kArrayBuffer = 0x8892, kElementArrayBuffer = 0x8893,
                      kStreamDraw = 0x88E0, kFramebuffer = 0x8D40, kRenderbuffer = 0x8D41,
                      kFramebufferComplete = 0x8CD5, kColorAttachment0 = 0x8CE0, kDepthAttachment = 0x8D00,
                      kVertexShader = 0x8B31, kFragmentShader = 0x8B30, kCompileStatus = 0x8B81,
                      kLinkStatus = 0x8B82, kUpperLeft = 0x8CA2, kLowerLeft = 0x8CA1, kZeroToOne = 0x935F,
                      kMajorVersion = 0x821B, kMinorVersion = 0x821C, kMaxRenderbufferSize = 0x84E8,
                      kMapWrite = 0x0002, kMapInvalidateBuffer = 0x0008, kDither = 0x0BD0;

// One line a function: result, name without gl, parameters.
#define TRIMRAY_GL_FUNCTIONS(X)                                                \
  X(Enum, GetError, (void))                                                    \
  X(const std::uint8_t*, GetString, (Enum))                                    \
  X(void, GetIntegerv, (Enum, Int*))                                           \
  X(void, Enable, (Enum))                                                      \
  X(void, Disable, (Enum))                                                     \
  X(void, DepthFunc, (Enum))                                                   \
  X(void, Viewport, (Int, Int, Sizei, Sizei))                                  \
  X(void, Flush, (void))                                                       \
  X(void, ClipControl, (Enum, Enum))                                           \
  X(void, PixelStorei, (Enum, Int))                                            \
  X(void, ReadBuffer, (Enum))                                                  \
  X(void, ReadPixels, (Int, Int, Sizei, Sizei, Enum, Enum, void*))             \
  X(void, DrawElements, (Enum, Sizei, Enum, const void*))                      \
  X(void, DrawBuffers, (Sizei, const Enum*))                                   \
  X(void, ClearBufferuiv, (Enum, Int, const Uint*))                            \
  X(void, ClearBufferfv, (Enum, Int, const float*))                            \
  X(void, GenFramebuffers, (Sizei, Uint*))                                     \
  X(void, BindFramebuffer, (Enum, Uint))                                       \
  X(Enum, CheckFramebufferStatus, (Enum))                                      \
  X(void, FramebufferRenderbuffer, (Enum, Enum, Enum, Uint))                   \
  X(void, GenRenderbuffers, (Sizei, Uint*))                                    \
  X(void, BindRenderbuffer, (Enum, Uint))                                      \
  X(void, RenderbufferStorage, (Enum, Enum, Sizei, Sizei))                     \
  X(void, GenBuffers, (Sizei, Uint*))                                          \
  X(void, BindBuffer, (Enum, Uint))                                            \
  X(void, BufferData, (Enum, Intptr, const void*, Enum))                       \
  X(void, GenVertexArrays, (Sizei, Uint*))                                     \
  X(void, BindVertexArray, (Uint))                                             \
  X(void, EnableVertexAttribArray, (Uint))                                     \
  X(void, VertexAttribPointer, (Uint, Int, Enum, Boolean, Sizei, const void*)) \
  X(void, VertexAttribIPointer, (Uint, Int, Enum, Sizei, const void*))         \
  X(Uint, CreateShader, (Enum))                                                \
  X(void, ShaderSource, (Uint, Sizei, const char* const*, const Int*))         \
  X(void, CompileShader, (Uint))                                               \
  X(void, GetShaderiv, (Uint, Enum, Int*))                                     \
  X(void, GetShaderInfoLog, (Uint, Sizei, Sizei*, char*))                      \
  X(Uint, CreateProgram, (void))                                               \
  X(void, AttachShader, (Uint, Uint))                                          \
  X(void, LinkProgram, (Uint))                                                 \
  X(void, GetProgramiv, (Uint, Enum, Int*))                                    \
  X(void, GetProgramInfoLog, (Uint, Sizei, Sizei*, char*))                     \
  X(void, UseProgram, (Uint))

struct Api {
#define TRIMRAY_GL_MEMBER(result, name, parameters) result(*name) parameters = nullptr;
  TRIMRAY_GL_FUNCTIONS(TRIMRAY_GL_MEMBER)
#undef TRIMRAY_GL_MEMBER

  // get("glX") gives the address of glX, or null. The name of a function that is missing, or null.
  template <typename Get>
  const char* load(const Get& get) {
#define TRIMRAY_GL_LOAD(result, name, parameters)                 \
  name = reinterpret_cast<result(*) parameters>(get("gl" #name)); \
  if (!name) return "gl" #name;
    TRIMRAY_GL_FUNCTIONS(TRIMRAY_GL_LOAD)
#undef TRIMRAY_GL_LOAD
    return nullptr;
  }
};

}  // namespace trimray::raster::gl
