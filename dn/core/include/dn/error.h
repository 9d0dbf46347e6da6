#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace dn {

/// A place in a file. line and column count from 1; 0 means unknown.
struct FileLocation {
  std::string file;
  long line = 0;
  long column = 0;

  /// Returns "file:line:column" without the unknown parts; empty if the file is unknown.
  std::string ToString() const;
};

/// Base class of the exceptions of dn. Only memory and files that fail give others:
/// std::bad_alloc and std::filesystem::filesystem_error.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Invalid input that can never work: bad data, shape, value or name. The message gives the item,
/// its value and its bound; `where` gives file and line if the input came from a file.
class InvalidInput : public Error {
 public:
  explicit InvalidInput(const std::string& what, FileLocation where = {})
      : Error(what), where_(std::move(where)) {}

  const FileLocation& where() const { return where_; }

 private:
  FileLocation where_;
};

/// Invalid configuration (flight.yaml, a scenario, an option), as opposed to the data that it
/// names.
class InvalidConfig : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// The measurements contain no information on some unknown. The message names the unknowns and
/// their epochs in the field's terms, and says what would determine them.
class RankDeficient : public Error {
 public:
  using Error::Error;
};

}  // namespace dn
