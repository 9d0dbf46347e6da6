#pragma once

#include <filesystem>
#include <string>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing {

/// A copy of a flight that a test may damage, with a folder for results.
class DamagedFlight {
 public:
  explicit DamagedFlight(const std::filesystem::path& flight = ShortFlight()) {
    std::filesystem::copy(flight, path(), std::filesystem::copy_options::recursive);
  }

  std::filesystem::path path() const { return folder_.path() / "flight"; }
  std::filesystem::path out() const { return folder_.path() / "out"; }

  std::string Read(const std::string& name) const { return FileContent(path() / name); }
  void Write(const std::string& name, const std::string& content) const {
    folder_.Write("flight/" + name, content);
  }

  /// Replaces the only occurrence of a text in a file. Throws if it does not occur exactly once.
  void Replace(const std::string& name, const std::string& old_text,
               const std::string& new_text) const {
    std::string content = Read(name);
    const std::size_t at = content.find(old_text);
    if (at == std::string::npos || content.find(old_text, at + 1) != std::string::npos) {
      throw std::runtime_error("not exactly once in " + name + ": " + old_text);
    }
    Write(name, content.replace(at, old_text.size(), new_text));
  }

  /// Replaces a line of a file. Line numbers start at 1.
  void ReplaceLine(const std::string& name, int line, const std::string& new_text) const {
    std::string content = Read(name);
    std::size_t begin = 0;
    for (int i = 1; i < line; ++i) begin = content.find('\n', begin) + 1;
    Write(name, content.replace(begin, content.find('\n', begin) - begin, new_text));
  }

  ProgramRun Run(const std::string& command, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{command, path().string(), "--out", out().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

 private:
  TempFolder folder_;
};

}  // namespace dn::testing
