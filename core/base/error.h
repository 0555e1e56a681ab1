// The errors that C++ entry points throw; core/bind maps each to a Python class.
//
//   Error
//   ├── FormatError   bytes that are not what they claim to be (B-rep stream, store file)
//   └── ArgumentError a caller's mistake
#pragma once

#include <stdexcept>
#include <string>

namespace trimray {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct FormatError : Error {
  using Error::Error;
};

struct ArgumentError : Error {
  using Error::Error;
};

}  // namespace trimray
