#include <dn/config/yaml_value.h>
#include <dn/names.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace dn {
namespace {

/// Magnitude limits of all numbers in files, in the units of their keys. Squares and inverses of
/// numbers within the limits stay finite.
constexpr double kLargest = 1e12;
constexpr double kSmallestPositive = 1e-12;

/// Parses all of `text` as a number of type T; a leading '+' is accepted.
template <class T>
bool ParseAll(std::string_view text, T& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

long LineNumber(const YAML::Mark& mark) { return mark.is_null() ? 0 : mark.line + 1; }
long ColumnNumber(const YAML::Mark& mark) { return mark.is_null() ? 0 : mark.column + 1; }

std::string OnOneLine(const YAML::Node& node) {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  out << node;
  return out.c_str();
}

std::string FaultText(const YAML::Exception& error) {
  if (dynamic_cast<const YAML::DeepRecursion*>(&error) != nullptr) {
    return "lists and maps are nested more than 500 deep";
  }
  return "not valid YAML: " + error.msg;
}

/// Throws InvalidConfig unless `node`, which is found under `parent` on the way to `path`, is a
/// map.
void ExpectRoomForKeys(const YAML::Node& node, const std::string& path, const std::string& parent) {
  if (node.IsMap()) return;
  throw InvalidConfig(path + ": " + (parent.empty() ? "the file" : "'" + parent + "'") +
                      " is not a map of keys");
}

/// Returns the beginning of the text without control characters, for messages.
std::string Shown(const std::string& text) {
  constexpr std::size_t kMostShown = 40;
  std::string shown = text.substr(0, kMostShown);
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < ' ') c = '?';
  }
  return shown + (text.size() > kMostShown ? "..." : "");
}

}  // namespace

/// Contains the yaml-cpp node. The default is an undefined node, which represents an absent value.
struct YamlValue::Node {
  YAML::Node yaml{YAML::NodeType::Undefined};
};

YamlValue::YamlValue(Node node, std::string path, std::string file, FileLocation parent)
    : node_(std::make_shared<const Node>(std::move(node))),
      path_(std::move(path)),
      file_(std::move(file)),
      parent_(std::move(parent)) {}

bool YamlValue::absent() const { return !node_->yaml.IsDefined() || node_->yaml.IsNull(); }
bool YamlValue::IsMap() const { return node_->yaml.IsDefined() && node_->yaml.IsMap(); }
bool YamlValue::IsScalar() const { return node_->yaml.IsDefined() && node_->yaml.IsScalar(); }
const std::string& YamlValue::Scalar() const { return node_->yaml.Scalar(); }

FileLocation YamlValue::where() const {
  const YAML::Mark mark = node_->yaml.IsDefined() ? node_->yaml.Mark() : YAML::Mark::null_mark();
  if (mark.is_null()) return {file_, parent_.line, parent_.column};
  return {file_, LineNumber(mark), ColumnNumber(mark)};
}

void YamlValue::Fail(const std::string& message) const {
  throw InvalidConfig(path_.empty() ? message : path_ + ": " + message, where());
}

std::string YamlValue::Found() const {
  if (absent()) return "nothing";
  if (IsMap()) return "a map";
  if (node_->yaml.IsSequence()) return "a list of " + std::to_string(node_->yaml.size());
  return "'" + Shown(Scalar()) + "'";
}

void YamlValue::FailType(const std::string& wanted) const {
  Fail("expected " + wanted + ", found " + Found());
}

void YamlValue::FailChoice(const std::string& word, const std::vector<std::string>& names) const {
  Fail("'" + Shown(word) + "' is not one of " + JoinNames(names) + "; did you mean '" +
       NearestName(word, names) + "'?");
}

void YamlValue::ExpectMap(const std::vector<std::string>& known) const {
  if (!IsMap()) FailType("a map of keys");
  std::vector<std::string> seen;
  for (const auto& entry : node_->yaml) {
    const YamlValue key({entry.first}, path_, file_, where());
    if (!entry.first.IsScalar()) key.Fail("a key must be plain text, not a list or map");
    const std::string& name = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      key.Fail("unknown key '" + Shown(name) + "'; did you mean '" + NearestName(name, known) +
               "'?");
    }
    if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
      key.Fail("key '" + name + "' is given twice");
    }
    seen.push_back(name);
  }
}

YamlValue YamlValue::operator[](const std::string& key) const {
  const std::string path = path_.empty() ? key : path_ + "." + key;
  if (!IsMap()) return {Node(), path, file_, where()};
  const YAML::Node child = node_->yaml[key];
  return {child.IsDefined() ? Node{child} : Node(), path, file_, where()};
}

std::size_t YamlValue::size() const { return absent() || IsScalar() ? 0 : node_->yaml.size(); }

std::vector<YamlValue> YamlValue::List(std::size_t most) const {
  if (!node_->yaml.IsSequence()) FailType("a list");
  if (size() > most) {
    Fail("has " + std::to_string(size()) + " elements, at most " + std::to_string(most) +
         " are read");
  }
  std::vector<YamlValue> items;
  for (std::size_t i = 0; i < node_->yaml.size(); ++i) {
    items.push_back({{node_->yaml[i]}, path_ + "[" + std::to_string(i) + "]", file_, where()});
  }
  return items;
}

std::vector<YamlValue> YamlValue::Items(std::size_t most) const {
  if (node_->yaml.IsSequence()) return List(most);
  return {*this};
}

std::string YamlValue::Text() const {
  if (absent() || !IsScalar() || Scalar().empty()) FailType("a word");
  return Scalar();
}

std::string YamlValue::Line(std::size_t longest) const {
  std::string line = Text();
  if (HasControls(line)) Fail("contains a line break or another control character");
  if (line.size() > longest) {
    Fail("must be one line of up to " + std::to_string(longest) + " characters");
  }
  return line;
}

bool YamlValue::Bool() const {
  if (!absent() && IsScalar()) {
    if (Scalar() == "true") return true;
    if (Scalar() == "false") return false;
  }
  FailType("true or false");
}

double YamlValue::Number() const {
  double value = 0.0;
  if (absent() || !IsScalar() || !ParseAll(Scalar(), value)) FailType("a number");
  if (!std::isfinite(value)) Fail("must be finite, is " + Shown(Scalar()));
  if (std::abs(value) > kLargest) Fail("must be within -1e12 and 1e12, is " + Found());
  return value;
}

long long YamlValue::Integer(long long lowest) const {
  long long value = 0;
  if (absent() || !IsScalar() || !ParseAll(Scalar(), value)) {
    FailType("an integer");
  }
  if (value < lowest) {
    Fail("must be at least " + std::to_string(lowest) + ", is " + Shown(Scalar()));
  }
  return value;
}

std::vector<std::string> YamlValue::Keys() const {
  std::vector<std::string> keys;
  if (!IsMap()) return keys;
  for (const auto& entry : node_->yaml) keys.push_back(entry.first.Scalar());
  return keys;
}

std::string YamlValue::Yaml() const {
  return node_->yaml.IsDefined() ? OnOneLine(node_->yaml) : "~";
}

void ExpectMapOrAbsent(const YamlValue& value, const std::vector<std::string>& known) {
  if (!value.absent()) value.ExpectMap(known);
}

std::string ReadName(const YamlValue& value) { return value.Line(100); }

double ReadPositive(const YamlValue& value) {
  const double number = value.Number();
  if (!(number > 0.0)) value.Fail("must be greater than 0, is " + Shown(value.Text()));
  if (number < kSmallestPositive) {
    value.Fail("must be at least 1e-12, is '" + Shown(value.Text()) + "'");
  }
  return number;
}

double ReadNotNegative(const YamlValue& value) {
  const double number = value.Number();
  if (number < 0.0) value.Fail("must not be negative, is " + Shown(value.Text()));
  return number;
}

Eigen::VectorXd ReadNumbers(const YamlValue& value, Eigen::Index size) {
  if (value.IsMap() || static_cast<Eigen::Index>(value.size()) != size) {
    value.FailType("a list of " + std::to_string(size) + " numbers");
  }
  Eigen::VectorXd numbers(size);
  const std::vector<YamlValue> items = value.List();
  for (Eigen::Index i = 0; i < size; ++i) numbers[i] = items[static_cast<std::size_t>(i)].Number();
  return numbers;
}

Eigen::Vector3d ReadVector3(const YamlValue& value) { return ReadNumbers(value, 3); }

Eigen::Vector3d ReadPositiveVector3(const YamlValue& value) {
  Eigen::Vector3d numbers = ReadVector3(value);
  if (!(numbers.minCoeff() > 0.0)) value.Fail("every element must be greater than 0");
  if (numbers.minCoeff() < kSmallestPositive) value.Fail("every element must be at least 1e-12");
  return numbers;
}

Eigen::Matrix3d ReadMatrix3(const YamlValue& value) {
  if (value.IsMap() || value.size() != 3) value.FailType("a 3 x 3 matrix, as a list of 3 rows");
  Eigen::Matrix3d matrix;
  const std::vector<YamlValue> rows = value.List();
  for (int i = 0; i < 3; ++i) matrix.row(i) = ReadVector3(rows[static_cast<std::size_t>(i)]);
  return matrix;
}

std::vector<double> ReadNumberList(const YamlValue& value) {
  std::vector<double> numbers;
  for (const YamlValue& item : value.Items()) numbers.push_back(item.Number());
  return numbers;
}

bool ReadBoolOr(const YamlValue& value, bool otherwise) {
  return value.absent() ? otherwise : value.Bool();
}

double ReadNumberOr(const YamlValue& value, double otherwise) {
  return value.absent() ? otherwise : value.Number();
}

double ReadPositiveOr(const YamlValue& value, double otherwise) {
  return value.absent() ? otherwise : ReadPositive(value);
}

double ReadNotNegativeOr(const YamlValue& value, double otherwise) {
  return value.absent() ? otherwise : ReadNotNegative(value);
}

Eigen::Vector3d ReadVector3Or(const YamlValue& value, const Eigen::Vector3d& otherwise) {
  return value.absent() ? otherwise : ReadVector3(value);
}

YamlValue ParseYaml(const std::string& text, const std::string& file) {
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsDefined() || root.IsNull()) {
      throw InvalidConfig("the configuration is empty", FileLocation{file, 1, 0});
    }
    return YamlValue({root}, "", file, {file, 1, 1});
  } catch (const YAML::Exception& e) {
    throw InvalidConfig(FaultText(e), FileLocation{file, LineNumber(e.mark), e.mark.column + 1});
  }
}

namespace {

constexpr std::size_t kLongestPath = 200;

void SetValue(const YAML::Node& root, const std::string& path, const std::string& value) {
  if (path.size() > kLongestPath) {
    throw InvalidConfig("'" + Shown(path) + "' is not a key: it has " +
                        std::to_string(path.size()) + " characters, at most " +
                        std::to_string(kLongestPath) + " are read");
  }
  try {
    YAML::Node place = root;
    std::size_t begin = 0;
    for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
      const std::string key = path.substr(begin, dot - begin);
      ExpectRoomForKeys(place, path, path.substr(0, begin));
      if (!place[key].IsDefined() || place[key].IsNull())
        place[key] = YAML::Node(YAML::NodeType::Map);
      place.reset(place[key]);
      begin = dot + 1;
    }
    ExpectRoomForKeys(place, path, path.substr(0, begin));
    place[path.substr(begin)] = YAML::Load(value);
  } catch (const YAML::Exception& e) {
    throw InvalidConfig(path + ": " + FaultText(e));
  }
}

using Change = std::pair<std::string, std::string>;

std::string WithValues(const std::string& text, const std::vector<Change>& changes) {
  if (changes.empty()) return text;
  try {
    const YAML::Node root = YAML::Load(text);
    for (const auto& [path, value] : changes) SetValue(root, path, value);
    YAML::Emitter out;
    out << root;
    return std::string(out.c_str()) + "\n";
  } catch (const YAML::Exception& e) {
    throw InvalidConfig(changes.front().first + ": " + FaultText(e));
  }
}

}  // namespace

std::string WithYamlValue(const std::string& text, const std::string& path,
                          const std::string& value) {
  return WithValues(text, {{path, value}});
}

std::string WithYamlChanges(const std::string& text, const std::vector<std::string>& changes,
                            const std::string& example) {
  std::vector<Change> values;
  for (const std::string& change : changes) {
    const std::size_t equals = change.find('=');
    if (equals == 0 || equals == std::string::npos) {
      throw InvalidConfig("'" + WithoutControls(change) +
                          "' is not of the form key=value; write for example " + example);
    }
    values.emplace_back(change.substr(0, equals), change.substr(equals + 1));
  }
  return WithValues(text, values);
}

}  // namespace dn
