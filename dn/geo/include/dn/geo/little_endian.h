#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

namespace dn {

/// Reads a number stored at `bytes` with the least significant byte first, on any machine.
template <class T>
T LoadLittleEndian(const char* bytes) {
  char own[sizeof(T)];
  std::copy(bytes, bytes + sizeof(T), own);
  if constexpr (std::endian::native == std::endian::big) std::reverse(own, own + sizeof(T));
  T value;
  std::memcpy(&value, own, sizeof(T));
  return value;
}

/// Writes a number to `bytes` with the least significant byte first.
template <class T>
void StoreLittleEndian(T value, char* bytes) {
  std::memcpy(bytes, &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes, bytes + sizeof(T));
}

template <class T>
void AppendLittleEndian(T value, std::string& out) {
  out.resize(out.size() + sizeof(T));
  StoreLittleEndian(value, out.data() + out.size() - sizeof(T));
}

}  // namespace dn
