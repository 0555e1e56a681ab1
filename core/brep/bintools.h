// The parser of OpenCascade's BinTools shape-set stream, version 4. It needs no OpenCascade header.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "core/brep/topology.h"

namespace trimray::brep {

// Reads a whole stream as written by BinTools_ShapeSet::Write (no root record).
// The bytes are hostile: every count and index is checked against what is left of the stream.
// Throws FormatError (with the byte offset and the section) and nothing else.
Model parse_bintools(std::span<const std::byte> bytes);

}  // namespace trimray::brep
