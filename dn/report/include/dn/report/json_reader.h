#pragma once

#include <dn/report/json.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Bounds of a JSON text. A text beyond one of them is refused while it is parsed, so that it can
/// neither fill the memory nor exhaust the stack.
struct JsonLimits {
  std::size_t bytes = std::size_t{64} << 20;
  std::size_t depth = 64;          ///< lists and objects inside each other
  std::size_t values = 4'000'000;  ///< of the whole text
  std::size_t keys = 10'000;       ///< of one object
};

/// Parses a JSON text: the one way in which this project reads JSON. Throws InvalidInput with file,
/// line and column for text that is not JSON. Throws it with file and JSON pointer (RFC 6901) for a
/// text beyond `limits` and for a key that an object has twice.
Json ParseJson(std::string_view text, const std::string& file, const JsonLimits& limits = {});

/// Values in a JSON tree, itself included.
std::size_t CountValues(const Json& json);

/// A key as a part of a JSON pointer.
std::string EscapedKey(const std::string& key);

/// A value in a JSON file whose readers expect a kind and a range. Every function throws
/// InvalidInput that names the file, the place as a JSON pointer and what was expected. The JSON
/// must outlive it.
class JsonPlace {
 public:
  /// The root of a file; no file is named where `file` is empty.
  // NOLINTNEXTLINE(google-explicit-constructor): a JSON value is the place of its root.
  JsonPlace(const Json& json, std::string file = "");

  bool is_null() const { return json_->is_null(); }
  /// Whether this is an object that has a key.
  bool Has(const std::string& key) const;
  JsonPlace At(const std::string& key) const;
  JsonPlace At(std::size_t index) const;  ///< of a list
  /// All elements of a list.
  std::vector<JsonPlace> Elements(std::size_t most = 100'000) const;

  double Number(double least = std::numeric_limits<double>::lowest(),
                double most = std::numeric_limits<double>::max()) const;
  /// NaN for null, which JSON has in its place.
  double NumberOrNaN() const;
  std::int64_t Integer(std::int64_t least, std::int64_t most) const;
  std::uint64_t Unsigned() const;
  bool Flag() const;
  std::string Text(std::size_t max_bytes = 10'000) const;
  std::vector<std::string> Texts() const;
  /// A list of three numbers, NaN for each null.
  Eigen::Vector3d Vector3() const;
  /// The same without null.
  Eigen::Vector3d FiniteVector3() const;
  /// A list of three rows, each a list of three numbers. NaN for null.
  Eigen::Matrix3d Matrix3() const;

  const Json& json() const { return *json_; }
  [[noreturn]] void Fail(const std::string& what) const;

 private:
  JsonPlace(const Json* json, std::string file, std::string pointer);

  const Json* json_;
  std::string file_;
  std::string pointer_;
};

}  // namespace dn
