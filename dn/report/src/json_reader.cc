#include <dn/error.h>
#include <dn/names.h>
#include <dn/report/json_reader.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace dn {
namespace {

constexpr std::size_t kMostShown = 60;

/// Returns the beginning of a text without control characters, for messages.
std::string Shown(const std::string& text) {
  const std::string plain = WithoutControls(text);
  return plain.size() > kMostShown ? plain.substr(0, kMostShown) + "..." : plain;
}

FileLocation FindLocation(std::string_view text, std::size_t position, const std::string& file) {
  const std::string_view before = text.substr(0, std::min(position, text.size()));
  const std::size_t line_begin = before.rfind('\n') + 1;  // 0 if there is none
  return {file, 1 + static_cast<long>(std::count(before.begin(), before.end(), '\n')),
          std::max(1L, static_cast<long>(before.size() - line_begin))};
}

/// Builds the tree of a text from the events of its parser, within limits.
class TreeBuilder {
 public:
  TreeBuilder(std::string_view text, const std::string& file, const JsonLimits& limits)
      : text_(text), file_(file), limits_(limits) {}

  Json Take() { return std::move(root_); }

  bool null() { return Add(Json()); }
  bool boolean(bool value) { return Add(value); }
  bool number_integer(Json::number_integer_t value) { return Add(value); }
  bool number_unsigned(Json::number_unsigned_t value) { return Add(value); }
  bool number_float(Json::number_float_t value, const std::string& /*text*/) { return Add(value); }
  bool string(std::string& value) { return Add(std::move(value)); }
  bool binary(Json::binary_t& /*value*/) { return false; }
  bool start_object(std::size_t /*size*/) { return Open(Json::object()); }
  bool start_array(std::size_t /*size*/) { return Open(Json::array()); }
  bool key(std::string& value) {
    key_ = std::move(value);
    return true;
  }
  bool end_object() {
    ExpectDifferentKeys();
    open_.pop_back();
    return true;
  }
  bool end_array() {
    open_.pop_back();
    return true;
  }
  template <class Error>
  bool parse_error(std::size_t position, const std::string& /*token*/, const Error& error) {
    const bool range = error.id == kNumberOverflow;
    throw InvalidInput(range ? "a number is too large for JSON" : "this is not JSON",
                       FindLocation(text_, position, file_));
  }

 private:
  static constexpr int kNumberOverflow = 406;

  template <class Value>
  bool Add(Value&& value) {
    Place(Json(std::forward<Value>(value)));
    return true;
  }

  bool Open(Json container) {
    if (open_.size() == limits_.depth) {
      Fail(fmt::format("lists and objects are nested deeper than {} levels", limits_.depth));
    }
    open_.push_back(&Place(std::move(container)));
    return true;
  }

  // A new key is appended without a look-up: looking up every key would take a time quadratic in
  // their number.
  Json& Place(Json value) {
    if (++values_ > limits_.values) Fail(fmt::format("more than {} values", limits_.values));
    if (open_.empty()) return root_ = std::move(value);
    Json& parent = *open_.back();
    if (auto* list = parent.get_ptr<Json::array_t*>()) return list->emplace_back(std::move(value));
    auto* object = parent.get_ptr<Json::object_t*>();
    if (object->size() == limits_.keys) Fail(fmt::format("more than {} keys", limits_.keys));
    return object->emplace_back(std::move(key_), std::move(value)).second;
  }

  void ExpectDifferentKeys() const {
    const auto& object = *open_.back()->get_ptr<const Json::object_t*>();
    std::vector<const std::string*> keys;
    for (const auto& item : object) keys.push_back(&item.first);
    const auto less = [](const std::string* a, const std::string* b) { return *a < *b; };
    std::sort(keys.begin(), keys.end(), less);
    const auto twice =
        std::adjacent_find(keys.begin(), keys.end(),
                           [](const std::string* a, const std::string* b) { return *a == *b; });
    if (twice != keys.end()) Fail("the key '" + Shown(**twice) + "' is given twice");
  }

  [[noreturn]] void Fail(const std::string& what) const {
    std::string pointer;
    for (std::size_t k = 0; k + 1 < open_.size(); ++k) pointer += "/" + LastKey(*open_[k]);
    throw InvalidInput((pointer.empty() ? "" : Shown(pointer) + ": ") + what, {file_});
  }

  static std::string LastKey(const Json& container) {
    if (container.is_array()) return std::to_string(container.size() - 1);
    return EscapedKey(container.get_ptr<const Json::object_t*>()->back().first);
  }

  std::string_view text_;
  const std::string& file_;
  const JsonLimits& limits_;
  Json root_;
  std::vector<Json*> open_;  // the lists and objects that have not ended
  std::string key_;
  std::size_t values_ = 0;
};

}  // namespace

std::string EscapedKey(const std::string& key) {
  std::string out;
  for (const char c : key) out += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return out;
}

Json ParseJson(std::string_view text, const std::string& file, const JsonLimits& limits) {
  if (text.size() > limits.bytes) {
    throw InvalidInput(
        fmt::format("JSON of {} bytes; at most {} are read", text.size(), limits.bytes), {file});
  }
  // The parser takes a zero byte for the end of the text.
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    throw InvalidInput("this is not JSON", FindLocation(text, zero + 1, file));
  }
  TreeBuilder builder(text, file, limits);
  Json::sax_parse(text.begin(), text.end(), &builder);
  return builder.Take();
}

std::size_t CountValues(const Json& json) {
  std::size_t count = 1;
  if (!json.is_structured()) return count;
  for (const Json& value : json) count += CountValues(value);
  return count;
}

JsonPlace::JsonPlace(const Json& json, std::string file) : JsonPlace(&json, std::move(file), "") {}

JsonPlace::JsonPlace(const Json* json, std::string file, std::string pointer)
    : json_(json), file_(std::move(file)), pointer_(std::move(pointer)) {}

void JsonPlace::Fail(const std::string& what) const {
  throw InvalidInput((pointer_.empty() ? "the file" : Shown(pointer_)) + " " + what, {file_});
}

bool JsonPlace::Has(const std::string& key) const {
  return json_->is_object() && json_->contains(key);
}

JsonPlace JsonPlace::At(const std::string& key) const {
  if (!json_->is_object()) Fail("is not an object");
  JsonPlace place(nullptr, file_, pointer_ + "/" + EscapedKey(key));
  const auto found = json_->find(key);
  if (found == json_->end()) place.Fail("is missing");
  place.json_ = &*found;
  return place;
}

JsonPlace JsonPlace::At(std::size_t index) const {
  if (!json_->is_array()) Fail("is not a list");
  if (index >= json_->size()) Fail(fmt::format("has {} elements, too few", json_->size()));
  return {&(*json_)[index], file_, pointer_ + "/" + std::to_string(index)};
}

std::vector<JsonPlace> JsonPlace::Elements(std::size_t most) const {
  if (!json_->is_array()) Fail("is not a list");
  if (json_->size() > most) Fail(fmt::format("has {} elements, at most {}", json_->size(), most));
  std::vector<JsonPlace> elements;
  elements.reserve(json_->size());
  for (std::size_t k = 0; k < json_->size(); ++k) elements.push_back(At(k));
  return elements;
}

double JsonPlace::Number(double least, double most) const {
  if (!json_->is_number()) Fail("is not a number");
  const double value = json_->get<double>();
  if (value < least || value > most) {
    Fail(fmt::format("is {:g}, not within {:g} and {:g}", value, least, most));
  }
  return value;
}

std::int64_t JsonPlace::Integer(std::int64_t least, std::int64_t most) const {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const bool fits = json_->is_number_unsigned() ? json_->get<std::uint64_t>() <= kMost
                                                : json_->is_number_integer();
  const std::int64_t value = fits ? json_->get<std::int64_t>() : 0;
  if (!fits || value < least || value > most) {
    Fail(fmt::format("is not an integer within {} and {}", least, most));
  }
  return value;
}

std::uint64_t JsonPlace::Unsigned() const {
  if (!json_->is_number_unsigned()) Fail("is not an integer of 64 bits");
  return json_->get<std::uint64_t>();
}

bool JsonPlace::Flag() const {
  if (!json_->is_boolean()) Fail("is neither true nor false");
  return json_->get<bool>();
}

std::string JsonPlace::Text(std::size_t max_bytes) const {
  const auto* text = json_->get_ptr<const Json::string_t*>();
  if (text == nullptr) Fail("is not a string");
  if (text->size() > max_bytes) Fail(fmt::format("is longer than {} bytes", max_bytes));
  return *text;
}

double ReadNumberOrNaN(const JsonPlace& place) {
  return place.is_null() ? std::numeric_limits<double>::quiet_NaN() : place.Number();
}

std::vector<std::string> ReadTexts(const JsonPlace& place) {
  std::vector<std::string> texts;
  for (const JsonPlace& element : place.Elements()) texts.push_back(element.Text());
  return texts;
}

Eigen::Vector3d ReadVector3(const JsonPlace& place) {
  const Json& list = place.json();
  if (!list.is_array() || list.size() != 3) place.Fail("is not a list of three");
  return {ReadNumberOrNaN(place.At(0)), ReadNumberOrNaN(place.At(1)), ReadNumberOrNaN(place.At(2))};
}

Eigen::Vector3d ReadFiniteVector3(const JsonPlace& place) {
  Eigen::Vector3d vector = ReadVector3(place);
  if (!vector.allFinite()) place.Fail("is not a list of three numbers");
  return vector;
}

Eigen::Matrix3d ReadMatrix3(const JsonPlace& place) {
  const Json& rows = place.json();
  if (!rows.is_array() || rows.size() != 3) place.Fail("is not a list of three rows");
  Eigen::Matrix3d matrix;
  for (std::size_t i = 0; i < 3; ++i) {
    matrix.row(static_cast<Eigen::Index>(i)) = ReadVector3(place.At(i));
  }
  return matrix;
}

}  // namespace dn
