#pragma once

#include <dlfcn.h>

#include <stdexcept>
#include <string>

/// A library of the system that few commands need, loaded when its first function is called for: most of what a short
/// run costs is the loading and linking of libraries. `POWBENCH_LATE(name)` declares a function of its header as a
/// member of a struct that has a `LateLibrary library`.

namespace powbench {

class LateLibrary {
 public:
  /// Throws std::runtime_error that names the file if it is not installed.
  explicit LateLibrary(const char* soname) : handle_(dlopen(soname, RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ == nullptr) throw std::runtime_error("cannot be loaded: " + std::string(dlerror()));
  }
  /// Function or variable of that name, also of the libraries that this one brings with it; nullptr: there is none.
  template <class Pointer>
  Pointer look_for(const char* name) const {
    return reinterpret_cast<Pointer>(dlsym(handle_, name));
  }
  /// The same. Throws std::runtime_error where there is none.
  template <class Pointer>
  Pointer find(const char* name) const {
    const auto found = look_for<Pointer>(name);
    if (found == nullptr) throw std::runtime_error("cannot be loaded: " + std::string(dlerror()));
    return found;
  }

 private:
  void* handle_;  ///< stays: what it started may still run at the end of the program
};

}  // namespace powbench

#define POWBENCH_LATE(name) decltype(&::name) name = library.find<decltype(&::name)>(#name)
