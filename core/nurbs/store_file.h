// What tests need to know of the file behind save_store and load_store.
#pragma once

#include <cstddef>
#include <span>

namespace trimray::nurbs {

// Makes the header's length and checksum agree with the bytes behind it, so that a file that was damaged on
// purpose reaches the checks behind the checksum. Does nothing to a file shorter than a header.
void reseal_store(std::span<std::byte> file);

}  // namespace trimray::nurbs
