#pragma once

#include <dlfcn.h>
#include <fmt/format.h>

#include <string>

#include "tagcal/error.hpp"

namespace tagcal::internal {

// Private to io: a library that is loaded at its first use, because it would load many others at
// each start of a program; it stays.
class LoadedLibrary {
 public:
  // `needed_by`: "videos", and `package` in the message if it is not installed.
  LoadedLibrary(const char* name, int version, const char* needed_by, const std::string& package)
      : name_(fmt::format("lib{}.so.{}", name, version)),
        handle_(::dlopen(name_.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_)
      throw Error(fmt::format("{} need {}, which is not installed (Debian: apt install {})",
                              needed_by, name_, package));
  }

  template <typename Function>
  void find(const char* function, Function*& address) const {
    address = reinterpret_cast<Function*>(::dlsym(handle_, function));
    if (!address) throw Error(fmt::format("{} has no function {}", name_, function));
  }

 private:
  std::string name_;
  void* handle_;
};

}  // namespace tagcal::internal
