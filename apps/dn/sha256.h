#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace dn::apps {

/// Returns the SHA-256 (FIPS 180-4) of `bytes` in hexadecimal digits.
std::string Sha256Hex(std::string_view bytes);

struct FileIdentity {
  std::uintmax_t bytes = 0;
  std::string sha256;
};

/// Returns size and SHA-256 of a file; nullopt if it cannot be read. Throws Interrupted after a
/// signal.
std::optional<FileIdentity> IdentifyFile(const std::filesystem::path& file);

/// Returns the SHA-256 of this program's executable file. It differs between two builds of one
/// version. Throws InvalidInput if the file cannot be read.
const std::string& ProgramHash();

}  // namespace dn::apps
