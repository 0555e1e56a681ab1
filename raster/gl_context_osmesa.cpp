// OSMesa: the only file that names it. Its five functions are declared here, since Mesa 25.1 dropped the
// library and its header; the numbers are those of GL/osmesa.h.
#include <cstdlib>
#include <cstring>

#include "raster/dynamic_library.h"
#include "raster/gl_context.h"

namespace trimray::raster {

namespace {

using Context = void*;
constexpr int kRgba = 0x1908, kFormat = 0x22, kDepthBits = 0x30, kStencilBits = 0x31, kAccumBits = 0x32,
              kProfile = 0x33, kCoreProfile = 0x34, kMajor = 0x36, kMinor = 0x37;
constexpr unsigned kUnsignedByte = 0x1401;

struct Library {
  DynamicLibrary library{"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
  Context (*create)(const int*, Context);
  void (*destroy)(Context);
  unsigned char (*make_current)(Context, void*, unsigned, int, int);
  void* (*function)(const char*);

  Library() {
    library.get(create, "OSMesaCreateContextAttribs");
    library.get(destroy, "OSMesaDestroyContext");
    library.get(make_current, "OSMesaMakeCurrent");
    library.get(function, "OSMesaGetProcAddress");
  }
};

class OsmesaContext final : public GlContext {
 public:
  OsmesaContext(const Library& library, Context context) : library_(library), context_(context) {}
  ~OsmesaContext() override { library_.destroy(context_); }
  void make_current() override {
    if (!library_.make_current(context_, screen_, kUnsignedByte, 1, 1))
      throw Error("OSMesa: the context cannot be made current");
  }
  void release() override { library_.make_current(nullptr, nullptr, 0, 0, 0); }
  void* function(const char* name) const override { return library_.function(name); }

 private:
  const Library& library_;
  Context context_;
  alignas(16) unsigned char screen_[16] = {};  // the context wants a picture to draw to; ours are elsewhere
};

class Osmesa final : public GlPlatform {
 public:
  std::unique_ptr<GlContext> make_context() override {
    const int attributes[] = {kFormat,  kRgba,        kDepthBits, 0, kStencilBits, 0, kAccumBits, 0,
                              kProfile, kCoreProfile, kMajor,     4, kMinor,       5, 0};
    const NoRasterThreads none;
    const Context context = library_.create(attributes, nullptr);
    if (!context) throw Error("OSMesa makes no context of OpenGL 4.5");
    serial_ = serial_ && NoRasterThreads::in_force();
    return std::make_unique<OsmesaContext>(library_, context);
  }
  bool survives_fork() const override { return serial_; }

 private:
  Library library_;
  bool serial_ = true;
};

}  // namespace

std::unique_ptr<GlPlatform> open_osmesa() { return std::make_unique<Osmesa>(); }

NoRasterThreads::NoRasterThreads() {
  if (std::getenv("LP_NUM_THREADS")) return;
  ours_ = setenv("LP_NUM_THREADS", "0", 0) == 0;
}
NoRasterThreads::~NoRasterThreads() {
  if (ours_) unsetenv("LP_NUM_THREADS");
}
bool NoRasterThreads::in_force() {
  const char* value = std::getenv("LP_NUM_THREADS");
  return value && std::strcmp(value, "0") == 0;
}

}  // namespace trimray::raster
