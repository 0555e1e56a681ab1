// OpenMesh's readers and writers keep state and print: one caller at a time, in silence.
#pragma once

#include <mutex>

#include <OpenMesh/Core/System/omstream.hh>

namespace trimray::tess {

class OpenMeshIo {
 public:
  OpenMeshIo() : lock_(mutex()) {
    omerr().disable();
    omlog().disable();
    omout().disable();
  }
  ~OpenMeshIo() {
    omerr().enable();
    omlog().enable();
    omout().enable();
  }
  OpenMeshIo(const OpenMeshIo&) = delete;
  OpenMeshIo& operator=(const OpenMeshIo&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex m;
    return m;
  }
  std::lock_guard<std::mutex> lock_;
};

}  // namespace trimray::tess
