// The streams that make_streams.py wrote, for all tests that need a B-rep without OpenCascade.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace trimray::testing {

inline std::filesystem::path stream_folder() {
  return std::filesystem::path(__FILE__).parent_path() / "data";
}

inline std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw std::runtime_error("cannot open " + path.string());
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.tellg()));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

// data/NAME.bin
inline std::vector<std::byte> read_stream(const std::string& name) {
  return read_bytes(stream_folder() / (name + ".bin"));
}

}  // namespace trimray::testing
