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

/// Parses a JSON text. All JSON that this project reads is parsed here. Throws InvalidInput with
/// file, line and column for text that is not JSON. A text beyond `limits`, and a key that an
/// object has twice, are reported with file and JSON pointer (RFC 6901).
Json ParseJson(std::string_view text, const std::string& file, const JsonLimits& limits = {});

/// Returns the number of values in a JSON tree, its root included.
std::size_t CountValues(const Json& json);

/// Returns a key in the form that it has in a JSON pointer.
std::string EscapedKey(const std::string& key);

/// A value in a JSON file, with functions that check its type and range. They throw InvalidInput
/// that names the file, the place as a JSON pointer, and what was expected. The JSON must outlive
/// the object.
class JsonPlace {
 public:
  /// Starts at the root of a file. Messages name no file if `file` is empty.
  // NOLINTNEXTLINE(google-explicit-constructor): a JSON value is the place of its root.
  JsonPlace(const Json& json, std::string file = "");

  bool is_null() const { return json_->is_null(); }
  /// Returns whether this is an object with the key.
  bool Has(const std::string& key) const;
  JsonPlace At(const std::string& key) const;
  JsonPlace At(std::size_t index) const;  ///< of a list
  /// Returns the elements of a list of at most `most` elements.
  std::vector<JsonPlace> Elements(std::size_t most = 100'000) const;

  double Number(double least = std::numeric_limits<double>::lowest(),
                double most = std::numeric_limits<double>::max()) const;
  std::int64_t Integer(std::int64_t least, std::int64_t most) const;
  std::uint64_t Unsigned() const;
  bool Flag() const;
  std::string Text(std::size_t max_bytes = 10'000) const;

  const Json& json() const { return *json_; }
  [[noreturn]] void Fail(const std::string& what) const;

 private:
  JsonPlace(const Json* json, std::string file, std::string pointer);

  const Json* json_;
  std::string file_;
  std::string pointer_;
};

/// Returns a number, or NaN for null, which stands for NaN in JSON.
double ReadNumberOrNaN(const JsonPlace& place);
std::vector<std::string> ReadTexts(const JsonPlace& place);
/// Returns a list of three numbers, with NaN for each null.
Eigen::Vector3d ReadVector3(const JsonPlace& place);
/// Returns a list of three numbers; null is not allowed.
Eigen::Vector3d ReadFiniteVector3(const JsonPlace& place);
/// Returns a list of three rows of three numbers, with NaN for each null.
Eigen::Matrix3d ReadMatrix3(const JsonPlace& place);

}  // namespace dn
