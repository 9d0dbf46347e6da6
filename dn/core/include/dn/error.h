#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace dn {

/// Where in a file something was found. line and column count from 1; 0 means unknown.
struct FileLocation {
  std::string file;
  long line = 0;
  long column = 0;

  /// "file:line:column", leaving out what is unknown; empty when the file is unknown.
  std::string ToString() const;
};

/// Something given to us can never work: bad data, shape, value or name. The message says what,
/// which value and which bound; `where` names the file and line when it came from one.
class InvalidInput : public std::runtime_error {
 public:
  explicit InvalidInput(const std::string& what, FileLocation where = {})
      : std::runtime_error(what), where_(std::move(where)) {}

  const FileLocation& where() const { return where_; }

 private:
  FileLocation where_;
};

/// The configuration (flight.yaml, a scenario, an option) is wrong, as opposed to the data it
/// names.
class InvalidConfig : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// The measurements carry no information on some unknown. The message names the unknowns in field
/// terms, when they are free, and what would fix it.
class RankDeficient : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace dn
