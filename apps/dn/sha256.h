#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace dn::apps {

/// SHA-256 (FIPS 180-4) in hexadecimal digits.
std::string Sha256Hex(std::string_view bytes);

struct FileIdentity {
  std::uintmax_t bytes = 0;
  std::string sha256;
};

/// Size and SHA-256 of a file; nothing where it cannot be read. Throws Interrupted when a signal
/// comes.
std::optional<FileIdentity> IdentifyFile(const std::filesystem::path& file);

/// SHA-256 of the file of this program, which differs between two builds of one version. Throws
/// InvalidInput where it cannot be read.
const std::string& ProgramHash();

}  // namespace dn::apps
