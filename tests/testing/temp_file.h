#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace dn::testing {

/// A file with the given bytes that is deleted with the object.
class TempFile {
 public:
  /// Creates the file; `name` has the extension that the reader under test needs.
  TempFile(const std::string& name, const std::string& content) {
    static int count = 0;
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("dn_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(folder_);
    path_ = folder_ / name;
    std::ofstream(path_, std::ios::binary) << content;
  }
  TempFile(const TempFile&) = delete;
  TempFile& operator=(const TempFile&) = delete;
  ~TempFile() { std::filesystem::remove_all(folder_); }

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path folder_, path_;
};

}  // namespace dn::testing
