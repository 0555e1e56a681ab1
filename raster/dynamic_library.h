// A shared library that is loaded when it is first needed, and stays loaded.
#pragma once

#include <dlfcn.h>

#include <initializer_list>
#include <string>

#include "core/base/error.h"

namespace trimray::raster {

class DynamicLibrary {
 public:
  // The first of the names that loads. Throws Error with the loader's word on the first one.
  explicit DynamicLibrary(std::initializer_list<const char*> names) {
    std::string first_error;
    for (const char* name : names) {
      handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);
      if (handle_) return;
      const char* error = dlerror();
      if (first_error.empty()) first_error = error ? error : name;
    }
    throw Error(first_error);
  }
  DynamicLibrary(const DynamicLibrary&) = delete;
  DynamicLibrary& operator=(const DynamicLibrary&) = delete;

  // Throws Error where the library has no such function.
  template <typename Function>
  void get(Function& function, const char* name) const {
    function = reinterpret_cast<Function>(dlsym(handle_, name));
    if (!function) throw Error(std::string("the library has no function ") + name);
  }

 private:
  void* handle_ = nullptr;
};

}  // namespace trimray::raster
