// Lines, words and numbers of a text file, with errors that say where.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace trimray::tess {

inline std::string_view trimmed(std::string_view s) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  const std::size_t begin = s.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return s.substr(begin, s.find_last_not_of(kBlank) - begin + 1);
}

// The first word of rest, taken off it; "" at its end.
inline std::string_view take_word(std::string_view& rest) {
  rest = trimmed(rest);
  const std::size_t end = rest.find_first_of(" \t\v\f\r\n");
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(word.size());
  return word;
}

// Walks over the lines of a text; any of \n, \r\n, \r ends one.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  // False at the end. line: without blanks at its ends.
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    std::size_t end = text_.find_first_of("\r\n", at_);
    if (end == std::string_view::npos) end = text_.size();
    line = trimmed(text_.substr(at_, end - at_));
    at_ = end + 1;
    if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] == '\n') ++at_;
    ++number_;
    return true;
  }
  std::size_t at() const { return at_; }  // where the next line begins
  [[noreturn]] void fail(const std::string& what) const {
    throw FormatError("line " + std::to_string(number_) + ": " + what);
  }

  double coordinate(std::string_view word) const {
    double value = 0.0;
    if (!number(word, value) || !std::isfinite(value)) fail(quoted(word) + " is not a coordinate");
    return value;
  }
  std::int64_t integer(std::string_view word) const {
    std::int64_t value = 0;
    if (!word.empty() && word[0] == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) fail(quoted(word) + " is not an index");
    return value;
  }
  static bool number(std::string_view word, double& value) {
    if (!word.empty() && word[0] == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::result_out_of_range && end == word.data() + word.size()) {
      value = std::strtod(std::string(word).c_str(), nullptr);  // 0 or infinity
      return true;
    }
    return error == std::errc() && end == word.data() + word.size();
  }
  static std::string quoted(std::string_view word) {
    if (word.empty()) return "nothing";
    std::string text = "'";
    for (const char c : word.substr(0, 40)) text += c >= 32 && c < 127 ? c : '?';
    return text + (word.size() > 40 ? "...'" : "'");
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::int64_t number_ = 0;
};

// Text of a double that reads back to the same double.
inline void append_number(std::string& text, double value) {
  char buffer[32];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

}  // namespace trimray::tess
