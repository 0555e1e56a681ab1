// A cursor over hostile bytes: every read is checked, and every failure names its section and offset.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/types.h"

namespace trimray::brep {

// Integers and reals are little-endian in the stream whatever machine wrote it.
static_assert(std::endian::native == std::endian::little, "byte order is not converted");

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::size_t left() const { return bytes_.size() - offset_; }
  void enter(const char* section) { section_ = section; }

  [[noreturn]] void fail(const std::string& what) const {
    throw FormatError("B-rep stream, " + std::string(section_) + ", byte " + std::to_string(offset_) + ": " +
                      what);
  }

  void skip(std::uint64_t count) {
    if (count > left()) fail("truncated");
    offset_ += static_cast<std::size_t>(count);
  }

  // Skips `count` items of a fixed size; count comes straight from the stream.
  void skip_items(std::int32_t count, std::uint64_t item_bytes) {
    skip(static_cast<std::uint64_t>(count) * item_bytes);
  }

  std::uint8_t byte() { return raw<std::uint8_t>(); }
  std::uint16_t short_integer() { return raw<std::uint16_t>(); }
  std::int32_t integer() { return raw<std::int32_t>(); }
  double real() { return raw<double>(); }

  bool flag() {
    const std::uint8_t value = byte();
    if (value > 1) fail("flag is neither 0 nor 1");
    return value == 1;
  }

  dvec2 vec2() {
    const double x = real(), y = real();
    return {x, y};
  }
  dvec3 vec3() {
    const double x = real(), y = real(), z = real();
    return {x, y, z};
  }
  glm::vec3 short_vec3() {
    const float x = raw<float>(), y = raw<float>(), z = raw<float>();
    return {x, y, z};
  }

  // A count of items that each take at least item_bytes of what is left, so that memory reserved for
  // them is bounded by the size of the stream.
  std::int32_t count(std::size_t item_bytes) { return checked_count(integer(), item_bytes); }
  std::int32_t checked_count(std::int64_t value, std::size_t item_bytes) const {
    if (value < 0) fail("negative count");
    if (static_cast<std::uint64_t>(value) > left() / item_bytes) fail("count exceeds what is left");
    return static_cast<std::int32_t>(value);
  }

  // A 1-based index into a table of `size` entries, returned 0-based.
  std::int32_t index(std::size_t size, const char* what) {
    const std::int32_t value = integer();
    if (value < 1 || static_cast<std::uint64_t>(value) > size)
      fail(std::string(what) + " index out of range");
    return value - 1;
  }
  // The same where 0 means absent, returned as -1.
  std::int32_t optional_index(std::size_t size, const char* what) {
    const std::int32_t value = integer();
    if (value < 0 || static_cast<std::uint64_t>(value) > size)
      fail(std::string(what) + " index out of range");
    return value - 1;
  }

  // Consumes `text` when the stream continues with it.
  bool accept(std::string_view text) {
    if (left() < text.size() || std::memcmp(bytes_.data() + offset_, text.data(), text.size()) != 0)
      return false;
    offset_ += text.size();
    return true;
  }

  // A section's header line "Name count\n"; returns the count, checked as in count().
  std::int32_t section(const char* name, std::size_t item_bytes) {
    section_ = name;
    if (!accept(name) || !accept(" ")) fail("section header expected");
    std::int64_t value = 0;
    int digits = 0;
    for (; left() > 0 && digits < 10; ++digits) {
      const auto c = static_cast<char>(bytes_[offset_]);
      if (c < '0' || c > '9') break;
      value = 10 * value + (c - '0');
      ++offset_;
    }
    if (digits == 0 || !accept("\n")) fail("section count expected");
    return checked_count(value, item_bytes);
  }

 private:
  template <typename T>
  T raw() {
    if (left() < sizeof(T)) fail("truncated");
    T value;
    std::memcpy(&value, bytes_.data() + offset_, sizeof(T));
    offset_ += sizeof(T);
    return value;
  }

  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  const char* section_ = "header";
};

}  // namespace trimray::brep
