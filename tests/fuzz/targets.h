// The functions that fuzzers and the replay test (tests/core/brep/corpus_test.cpp) both call. Each takes
// arbitrary bytes and returns when they are handled as promised; anything else escapes as an exception
// or is caught by a sanitizer.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "core/brep/bintools.h"
#include "tests/core/brep/promises.h"

namespace trimray::fuzz {

// Bytes -> Model. FormatError is the only way to refuse.
inline void parse_stream(std::span<const std::byte> bytes) {
  try {
    testing::check_promises(brep::parse_bintools(bytes));
  } catch (const FormatError&) {
  }
}

}  // namespace trimray::fuzz
