// EGL without a window: a graphics card where there is one, else Mesa on the processor. Its functions and
// numbers are declared here, as EGL/egl.h and EGL/eglext.h have them.
#include <cstdint>
#include <cstring>
#include <string>

#include "raster/dynamic_library.h"
#include "raster/gl_context.h"

namespace trimray::raster {

namespace {

using Display = void*;
using Device = void*;
using Config = void*;
using Context = void*;
constexpr unsigned kOpenGlApi = 0x30A2, kPlatformDevice = 0x313F, kPlatformSurfaceless = 0x31DD;
constexpr std::int32_t kExtensions = 0x3055, kSurfaceType = 0x3033, kPbuffer = 0x0001,
                       kRenderableType = 0x3040, kOpenGlBit = 0x0008, kMajor = 0x3098, kMinor = 0x30FB,
                       kProfileMask = 0x30FD, kCoreBit = 1, kNone = 0x3038;

struct Library {
  DynamicLibrary library{"libEGL.so.1", "libEGL.so"};
  void* (*function)(const char*);
  const char* (*query_string)(Display, std::int32_t);
  unsigned (*initialize)(Display, std::int32_t*, std::int32_t*);
  unsigned (*terminate)(Display);
  unsigned (*bind_api)(unsigned);
  unsigned (*choose_config)(Display, const std::int32_t*, Config*, std::int32_t, std::int32_t*);
  Context (*create)(Display, Config, Context, const std::int32_t*);
  unsigned (*destroy)(Display, Context);
  unsigned (*make_current)(Display, void*, void*, Context);
  unsigned (*release_thread)();
  std::int32_t (*error)();
  // Of extensions.
  Display (*platform_display)(unsigned, void*, const std::int32_t*);
  unsigned (*query_devices)(std::int32_t, Device*, std::int32_t*);
  const char* (*query_device_string)(Device, std::int32_t);

  Library() {
    library.get(function, "eglGetProcAddress");
    library.get(query_string, "eglQueryString");
    library.get(initialize, "eglInitialize");
    library.get(terminate, "eglTerminate");
    library.get(bind_api, "eglBindAPI");
    library.get(choose_config, "eglChooseConfig");
    library.get(create, "eglCreateContext");
    library.get(destroy, "eglDestroyContext");
    library.get(make_current, "eglMakeCurrent");
    library.get(release_thread, "eglReleaseThread");
    library.get(error, "eglGetError");
    extension(platform_display, "eglGetPlatformDisplayEXT");
    extension(query_devices, "eglQueryDevicesEXT");
    extension(query_device_string, "eglQueryDeviceStringEXT");
    if (!platform_display) throw Error("EGL knows no platforms without windows");
  }
  template <typename Function>
  void extension(Function& f, const char* name) {
    f = reinterpret_cast<Function>(function(name));
  }
  std::string failure(const char* what) const {
    char text[16];
    std::snprintf(text, sizeof text, "0x%04x", static_cast<unsigned>(error()));
    return std::string("EGL: ") + what + " fails with " + text;
  }
};

// `word` stands in a list of words parted by blanks.
bool has(const char* list, const char* word) {
  const std::string all = std::string(" ") + (list ? list : "") + " ";
  return all.find(std::string(" ") + word + " ") != std::string::npos;
}

class EglContext final : public GlContext {
 public:
  EglContext(const Library& library, Display display, Context context)
      : library_(library), display_(display), context_(context) {}
  ~EglContext() override { library_.destroy(display_, context_); }
  void make_current() override {
    library_.bind_api(kOpenGlApi);
    if (!library_.make_current(display_, nullptr, nullptr, context_))
      throw Error(library_.failure("eglMakeCurrent"));
  }
  // The thread's own state goes, too: what EGL keeps of a thread that lives until the process ends is freed
  // twice then, by the thread and by EGL (seen with Mesa 22.3).
  void release() override {
    library_.make_current(display_, nullptr, nullptr, nullptr);
    library_.release_thread();
  }
  void* function(const char* name) const override { return library_.function(name); }

 private:
  const Library& library_;
  Display display_;
  Context context_;
};

class Egl final : public GlPlatform {
 public:
  // A card's display first; a display that opens but makes no context of 4.5 is passed over.
  Egl() {
    const NoRasterThreads none;
    const ThreadState state{library_};
    const char* client = library_.query_string(nullptr, kExtensions);
    std::string why = "EGL finds neither a device nor Mesa's platform without surfaces";
    if (library_.query_devices && library_.query_device_string && has(client, "EGL_EXT_platform_device")) {
      Device devices[16];
      std::int32_t count = 0;
      if (!library_.query_devices(16, devices, &count)) count = 0;
      for (std::int32_t i = 0; i < count; ++i) {
        const char* extensions = library_.query_device_string(devices[i], kExtensions);
        if (has(extensions, "EGL_MESA_device_software")) continue;
        if (open(library_.platform_display(kPlatformDevice, devices[i], nullptr), why)) return;
      }
    }
    survives_fork_ = NoRasterThreads::in_force();
    if (has(client, "EGL_MESA_platform_surfaceless") &&
        open(library_.platform_display(kPlatformSurfaceless, nullptr, nullptr), why))
      return;
    throw Error(why);
  }

  std::unique_ptr<GlContext> make_context() override {
    const std::int32_t attributes[] = {kMajor, 4, kMinor, 5, kProfileMask, kCoreBit, kNone};
    const NoRasterThreads none;
    library_.bind_api(kOpenGlApi);
    const Context context = library_.create(display_, config_, nullptr, attributes);
    if (!context) throw Error(library_.failure("a context of OpenGL 4.5"));
    return std::make_unique<EglContext>(library_, display_, context);
  }
  bool survives_fork() const override { return survives_fork_; }

 private:
  struct ThreadState {
    const Library& library;
    ~ThreadState() { library.release_thread(); }
  };

  bool open(Display display, std::string& why) {
    if (!display || !library_.initialize(display, nullptr, nullptr)) {
      why = library_.failure("eglInitialize");
      return false;
    }
    display_ = display, config_ = nullptr;
    if (!has(library_.query_string(display, kExtensions), "EGL_KHR_no_config_context")) {
      const std::int32_t wanted[] = {kSurfaceType, kPbuffer, kRenderableType, kOpenGlBit, kNone};
      std::int32_t count = 0;
      if (!library_.choose_config(display, wanted, &config_, 1, &count) || count == 0) {
        why = library_.failure("eglChooseConfig");
        return false;
      }
    }
    try {
      make_context()->make_current();
      library_.make_current(display_, nullptr, nullptr, nullptr);
      return true;
    } catch (const Error& error) {
      why = error.what();
      return false;
    }
  }

  Library library_;
  Display display_ = nullptr;
  Config config_ = nullptr;
  bool survives_fork_ = false;
};

}  // namespace

std::unique_ptr<GlPlatform> open_egl() { return std::make_unique<Egl>(); }

}  // namespace trimray::raster
