#include "column_meaning.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <optional>
#include <vector>

#include "lower_case.h"
#include "name_words.h"

namespace dn::files_internal {
namespace {

using NamePart = std::string_view;
using Choices = std::initializer_list<NamePart>;

bool IsLetter(const NamePart& name, std::size_t at) {
  return at < name.size() && (IsLower(name[at]) || IsUpper(name[at]));
}

/// Returns whether a capital begins a word, as in "rotationRate", "IMUAcc", "accX" and "xAcc".
/// Single letters other than an axis belong to the next word, as in "dT" and "HDop". A height is an
/// exception: "hEll".
bool BeginsWord(NamePart name, std::size_t at) {
  constexpr NamePart kAxes = "xyzXYZ";
  if (at == 0 || !IsUpper(name[at])) return false;
  const bool axis_after = kAxes.find(name[at]) != NamePart::npos && !IsLetter(name, at + 1);
  const bool word_after = IsLetter(name, at + 1);
  const bool word_before =
      (at > 1 && IsLetter(name, at - 2)) || kAxes.find(name[at - 1]) != NamePart::npos;
  const bool is_height = name.substr(at).starts_with("Ell") || name.substr(at).starts_with("MSL");
  if (is_height && LowerCase(name.substr(0, at)).ends_with('h')) return true;
  if (IsLower(name[at - 1])) return axis_after || (word_after && word_before);
  return IsUpper(name[at - 1]) && word_before && at + 2 < name.size() && IsLower(name[at + 1]) &&
         IsLower(name[at + 2]);
}

/// Puts blanks before the words that begin with a capital.
std::string WithWordsApart(NamePart name) {
  std::string apart;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (BeginsWord(name, i)) apart += ' ';
    apart += name[i];
  }
  return apart;
}

/// Words that may be joined with an axis or a direction: "accx", "wy", "sdn", "vnorth", "tx".
constexpr std::array<NamePart, 34> kStems{"acc",
                                          "accel",
                                          "acceleration",
                                          "accelerometer",
                                          "a",
                                          "f",
                                          "gyr",
                                          "gyro",
                                          "gyroscope",
                                          "w",
                                          "omega",
                                          "rate",
                                          "angularvelocity",
                                          "g",
                                          "v",
                                          "vel",
                                          "velocity",
                                          "sd",
                                          "std",
                                          "sigma",
                                          "sdv",
                                          "q",
                                          "quat",
                                          "mag",
                                          "stdv",
                                          "t",
                                          "p",
                                          "pos",
                                          "position",
                                          "gyros",
                                          "angrate",
                                          "angularrate",
                                          "force",
                                          "gravity"};
constexpr std::array<NamePart, 13> kEndings{"north", "east", "up", "down", "height", "x", "y",
                                            "z",     "w",    "n",  "e",    "u",      "d"};

bool IsStem(NamePart word) { return std::find(kStems.begin(), kStems.end(), word) != kStems.end(); }

bool IsAxis(NamePart word) { return word == "x" || word == "y" || word == "z"; }

/// Splits the number of a sensor from the words, so that "gyro1" becomes "gyro" and "1".
std::vector<std::string> WithNumberApart(const std::vector<std::string>& words) {
  constexpr std::size_t kLeastStem = 3;
  std::vector<std::string> apart;
  for (const std::string& word : words) {
    const std::size_t end = word.find_last_not_of("0123456789") + 1;
    const bool numbered = end < word.size() && end >= kLeastStem && IsStem(word.substr(0, end));
    apart.push_back(numbered ? word.substr(0, end) : word);
    if (numbered) apart.push_back(word.substr(end));
  }
  return apart;
}

/// Splits an axis or a direction from the words, so that "accx" and "xacc" become "acc" and "x".
std::vector<std::string> WithAxisApart(const std::vector<std::string>& words) {
  constexpr std::size_t kLeastAfterAxis = 3;  // "xt" is not an axis with a stem
  std::vector<std::string> apart;
  for (const NamePart word : words) {
    const auto ending = std::find_if(kEndings.begin(), kEndings.end(), [&](NamePart each) {
      return word.ends_with(each) && IsStem(word.substr(0, word.size() - each.size()));
    });
    const bool axis_first =
        word.size() > kLeastAfterAxis && IsAxis(word.substr(0, 1)) && IsStem(word.substr(1));
    if (axis_first) {
      apart.emplace_back(word.substr(1));
      apart.emplace_back(word.substr(0, 1));
    } else if (ending == kEndings.end()) {
      apart.emplace_back(word);
    } else {
      apart.emplace_back(word.substr(0, word.size() - ending->size()));
      apart.emplace_back(*ending);
    }
  }
  return apart;
}

/// A name without its unit, as words in lower case. A word of several words such as "GPSTime" is
/// there as a whole and in parts.
class NameWords {
 public:
  explicit NameWords(NamePart name)
      : words_(WithAxisApart(WithNumberApart(SplitWords(LowerCase(name))))),
        apart_(WithAxisApart(WithNumberApart(SplitWords(LowerCase(WithWordsApart(name)))))) {
    whole_ = words_.size();
    if (apart_ != words_) words_.insert(words_.end(), apart_.begin(), apart_.end());
  }

  /// Returns the parts of the name, each once.
  const std::vector<std::string>& parts() const { return apart_; }

  bool Any(Choices choices) const {
    return std::any_of(choices.begin(), choices.end(),
                       [this](NamePart choice) { return Is(choice); });
  }
  bool Is(NamePart word) const {
    return std::find(words_.begin(), words_.end(), word) != words_.end();
  }
  bool Only(NamePart word) const { return whole_ == 1 && words_[0] == word; }

  /// Returns the letter of the axis x, y, z; 0 if the name has none.
  char BodyAxis() const {
    for (const char axis : {'x', 'y', 'z'}) {
      if (Is(NamePart(&axis, 1))) return axis;
    }
    return 0;
  }

  /// Returns the direction e, n, u, d; 0 if the name has none.
  char MapDirection() const {
    struct MapDirection {
      char letter;
      std::initializer_list<NamePart> words;
    };
    const std::array<MapDirection, 4> all{
        {{'e', {"e", "east", "lon", "longitude"}},
         {'n', {"n", "north", "lat", "latitude"}},
         {'u', {"u", "up", "h", "height", "hgt", "alt", "altitude"}},
         {'d', {"d", "down"}}}};
    for (const MapDirection& each : all) {
      if (Any(each.words)) return each.letter;
    }
    return 0;
  }

 private:
  std::vector<std::string> words_, apart_;
  std::size_t whole_ = 0;
};

bool IsMinutes(const std::string& unit) {
  return unit == "min" || unit == "mins" || unit.starts_with("minute");
}

/// Returns whether the unit is one of times, but not one that a file can be read in.
bool IsLongTime(const std::string& unit) {
  return unit == "h" || unit == "hr" || unit == "d" || unit.starts_with("hour") ||
         unit.starts_with("day");
}

bool IsTimeUnit(const std::string& unit) {
  for (const NamePart each :
       {"s", "sec", "secs", "second", "seconds", "ms", "msec", "millisecond", "milliseconds", "us",
        "microsecond", "microseconds", "ns", "nanosecond", "nanoseconds"}) {
    if (unit == each) return true;
  }
  return IsMinutes(unit);
}

std::string TimeName(const NameWords& words, const std::string& unit) {
  if (words.Any({"week", "wk", "weekno", "gpsweek"}) &&
      !words.Any({"seconds", "sec", "secs", "of"})) {
    return "week";
  }
  const bool is_time =
      words.Any({"time", "timestamp", "t", "tow", "sow", "gpstime", "utctime", "itow", "stamp",
                 "seconds", "secs", "gpsseconds", "epoch", "zeit", "tiempo"});
  const bool is_interval = words.Any({"delta", "relative", "interval", "acc", "accuracy"});
  if (!is_time || is_interval || words.BodyAxis() != 0 || words.Any({"date", "datetime"})) {
    return {};
  }
  if (IsLongTime(unit)) return kOtherQuantity;
  if (!unit.empty() && !IsTimeUnit(unit)) return {};
  if (IsMinutes(unit)) return "t_min";
  if (unit.starts_with("ms") || unit.starts_with("milli") || words.Any({"ms", "msec", "millis"})) {
    return "t_ms";
  }
  if (unit.starts_with("us") || unit.starts_with("micro") || words.Any({"us", "usec", "micros"})) {
    return "t_us";
  }
  if (unit.starts_with("ns") || unit.starts_with("nano") ||
      words.Any({"ns", "nsec", "nsecs", "nanos", "nanosec"})) {
    return "t_ns";
  }
  return "t";
}

bool IsSigma(const NameWords& words) {
  return words.Any({"sd", "std", "stdev", "stddev", "sigma", "rms", "sdv", "stdv", "accuracy"});
}

bool IsNotInertial(const NameWords& words) {
  return words.Any({"mag", "magnetic", "magnetometer", "magnetfeld", "gravity", "euler"});
}

/// Returns kRate or kForce for a sensor of inertial data, else nothing.
std::string InertialQuantity(const NameWords& words) {
  if (IsSigma(words) || IsNotInertial(words) || words.Any({"covariance", "bias"})) return {};
  if (words.Any({"gyr", "gyro", "gyroscope", "gyros", "angular", "angularvelocity", "angularrate",
                 "angrate", "omega", "w", "rate", "rot", "imugyro"})) {
    return kRate;
  }
  if (words.Any({"acc", "accel", "accelerometer", "acceleration", "accels", "force",
                 "specificforce", "f", "a"})) {
    return kForce;
  }
  // "gx" stands for a gyro beside "ax", and for nothing else.
  return words.Is("g") ? kRate : "";
}

std::string InertialName(const NameWords& words) {
  const char axis = words.BodyAxis();
  const std::string quantity = axis == 0 ? std::string() : InertialQuantity(words);
  return quantity.empty() ? quantity : quantity + axis;
}

/// Returns a count of rows, or a vector that is neither of inertial data nor a position.
std::string OtherName(const NameWords& words) {
  if (words.Any({"counter", "count", "packetcounter", "packet", "sequence", "seq", "index"})) {
    return kRowCount;
  }
  const bool velocity = words.Any({"v", "vel", "velocity"}) && words.BodyAxis() != 0;
  return IsNotInertial(words) || velocity ? kOtherQuantity : "";
}

std::string AttitudeName(const NameWords& words) {
  if (IsSigma(words) || words.Any({"rate", "speed", "bias", "gimbal"})) return {};
  if (words.Any({"q", "quat", "quaternion", "orientation"})) {
    for (const char axis : {'w', 'x', 'y', 'z'}) {
      if (words.Is(NamePart(&axis, 1))) return std::string("q") + axis;
    }
  }
  for (const char* each : {"qw", "qx", "qy", "qz", "roll", "pitch", "heading"}) {
    if (words.Is(each)) return each;
  }
  return words.Any({"yaw", "azimuth"}) ? "heading" : "";
}

/// Names a coordinate in m: "east" and "north" of a grid, or "x", "y", "z".
std::string PlaneName(const NameWords& words) {
  if (words.Any({"easting", "east"})) return "east";
  if (words.Any({"northing", "north"})) return "north";
  if (words.Is("up")) return "up";
  const char axis = words.BodyAxis();
  const bool position = words.Any({"t", "p", "pos", "position", "translation", "ecef"});
  return axis != 0 && (position || words.Only(NamePart(&axis, 1))) ? std::string(1, axis) : "";
}

std::string MapName(const NameWords& words) {
  const bool velocity = words.Any({"v", "vel", "velocity", "sdv", "stdv"});
  const char direction = words.MapDirection();
  if (IsSigma(words) || velocity) {
    if (direction == 0) return {};
    const std::string prefix = IsSigma(words) ? (velocity ? "sigma_v" : "sigma_") : "v";
    return prefix + direction;
  }
  const bool has_height = words.Any({"h", "height", "hgt", "alt", "altitude", "ellipsoidal"});
  if (words.Is("undulation") || (words.Is("geoid") && !words.Is("above"))) return "undulation";
  if (words.Any({"sea", "sealevel", "msl", "amsl", "orthometric", "geoid"})) {
    return has_height || words.Any({"msl", "amsl"}) ? "h_msl" : "";
  }
  if (words.Any({"above", "separation", "sonar", "max", "baro", "barometric", "pressure",
                 "relative", "rel", "agl", "home", "acc"})) {
    return {};
  }
  for (const char* angle : {"lat", "lon"}) {
    if (!words.Any(angle == NamePart("lat") ? Choices{"lat", "latitude"}
                                            : Choices{"lon", "lng", "long", "longitude"})) {
      continue;
    }
    if (words.Any({"min", "minutes"})) return std::string(angle) + "_min";
    return words.Any({"sec", "seconds"}) ? std::string(angle) + "_sec" : angle;
  }
  return has_height ? "h" : PlaneName(words);
}

/// Replaces the signs of units by letters, in the encodings that programs write.
std::string WithPlainSigns(NamePart name) {
  struct Sign {
    NamePart bytes, plain;
  };
  // Single bytes are those of Latin-1, unless they continue a character of UTF-8.
  static constexpr std::array<Sign, 13> kSigns{{{"\xC2\xB0", " deg "},
                                                {"\xC2\xBA", " deg "},
                                                {"\xC2\xB2", "2"},
                                                {"\xC2\xB9", "1"},
                                                {"\xC2\xB7", "."},
                                                {"\xC2\xB5", "u"},
                                                {"\xCE\xBC", "u"},
                                                {"\xE2\x81\xBB", "-"},
                                                {"\xE2\x88\x92", "-"},
                                                {"\xE2\x8B\x85", "."},
                                                {"\xB0", " deg "},
                                                {"\xB2", "2"},
                                                {"\xB5", "u"}}};
  std::string plain;
  while (!name.empty()) {
    const bool continues = !plain.empty() && static_cast<unsigned char>(plain.back()) >= 0x80;
    const auto sign = std::find_if(kSigns.begin(), kSigns.end(), [&](const Sign& each) {
      return name.starts_with(each.bytes) && !(continues && each.bytes.size() == 1);
    });
    if (sign == kSigns.end()) {
      plain += name.front();
      name.remove_prefix(1);
    } else {
      plain += sign->plain;
      name.remove_prefix(sign->bytes.size());
    }
  }
  return plain;
}

/// Parts of a name such as "gyro_rad[0]" or "Acc X (m/s^2)".
struct NameAndUnit {
  std::string name, unit;
  int index = -1;
};

bool IsNumber(NamePart text) {
  return !text.empty() && text.find_first_not_of("0123456789") == NamePart::npos;
}

NameAndUnit SplitUnit(NamePart column) {
  const std::string plain = WithPlainSigns(column);
  NameAndUnit parts;
  const std::size_t open = std::min(plain.find_first_of("([{<"), plain.size());
  for (const char c : LowerCase(NamePart(plain).substr(open))) {
    if (NamePart("([{<>}]) \t").find(c) == NamePart::npos) parts.unit += c;
  }
  parts.name = plain.substr(0, open);
  if (IsNumber(parts.unit)) {
    parts.index = parts.unit.size() == 1 ? parts.unit[0] - '0' : -1;
    parts.unit.clear();
  }
  return parts;
}

/// Returns the words of a unit at the end of a name, as in "wX_dps", "gyro_x_rad_s" and "acc_mg_x".
std::string EndingUnit(std::vector<std::string> words) {
  constexpr std::array<NamePart, 19> kUnitWords{"rad", "deg", "mrad", "mdeg", "s",   "s2", "m",
                                                "g",   "mg",  "dps",  "mdps", "mps", "h",  "mps2",
                                                "ms2", "2",   "sec",  "rpm",  "ug"};
  std::erase_if(words, [](const std::string& word) { return IsAxis(word); });
  std::size_t begin = words.size();
  while (begin > 1 &&
         std::find(kUnitWords.begin(), kUnitWords.end(), words[begin - 1]) != kUnitWords.end()) {
    --begin;
  }
  std::string unit;
  for (std::size_t i = begin; i < words.size(); ++i) unit += words[i];
  return unit;
}

std::string SensorWords(const NameWords& words) {
  std::string sensor;
  for (const std::string& word : words.parts()) {
    if (!IsAxis(word)) sensor += (sensor.empty() ? "" : " ") + word;
  }
  return sensor;
}

/// Splits a number from the end of a name, as in "acc1", "acc_1" and "acc.1"; -1 without one.
int SplitIndex(std::string* name) {
  if (name->size() < 2 || !IsNumber(NamePart(*name).substr(name->size() - 1))) return -1;
  const int index = name->back() - '0';
  const char before = (*name)[name->size() - 2];
  if (IsNumber(NamePart(&before, 1))) return -1;
  name->pop_back();
  return index;
}

/// Returns the meaning of a rate or a force whose axis is a number or a direction, else nothing.
std::optional<ColumnMeaning> IndexedMeaning(const NameAndUnit& parts) {
  std::string name = parts.name;
  const int index = parts.index >= 0 ? parts.index : SplitIndex(&name);
  const NameWords words(name);
  const bool direction = words.Any({"right", "left", "forward", "up", "down"});
  if ((index < 0 && !direction) || words.BodyAxis() != 0) return std::nullopt;
  const std::string quantity = InertialQuantity(words);
  if (quantity.empty()) return std::nullopt;
  const std::string unit = parts.unit.empty() ? EndingUnit(words.parts()) : parts.unit;
  return ColumnMeaning{quantity, unit, SensorWords(words), index};
}

}  // namespace

ColumnMeaning FindMeaning(std::string_view column) {
  const NameAndUnit parts = SplitUnit(column);
  const NameWords words(parts.name);
  if (const std::string time = TimeName(words, parts.unit); !time.empty()) {
    return {time, parts.unit};
  }
  if (const std::string inertial = InertialName(words); !inertial.empty()) {
    const std::string unit = parts.unit.empty() ? EndingUnit(words.parts()) : parts.unit;
    return {inertial, unit, SensorWords(words)};
  }
  if (std::optional<ColumnMeaning> indexed = IndexedMeaning(parts)) return *indexed;
  for (const auto& find : {AttitudeName, MapName, OtherName}) {
    if (const std::string found = find(words); !found.empty()) return {found, parts.unit};
  }
  return {"", parts.unit};
}

}  // namespace dn::files_internal
