#include "column_meaning.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <optional>
#include <vector>

#include "lower_case.h"

namespace dn::files_internal {
namespace {

using NamePart = std::string_view;
using Choices = std::initializer_list<NamePart>;

/// Splits a name in lower case into words of letters and digits.
std::vector<std::string> SplitWords(NamePart name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// Words that may be joined with an axis or a direction: "accx", "wy", "sdn", "vnorth", "tx".
constexpr std::array<NamePart, 29> kStems{"acc",
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
                                          "position"};
constexpr std::array<NamePart, 13> kEndings{"north", "east", "up", "down", "height", "x", "y",
                                            "z",     "w",    "n",  "e",    "u",      "d"};

/// Splits an axis or a direction from the words, so that "accx" becomes "acc", "x".
std::vector<std::string> WithAxisApart(const std::vector<std::string>& words) {
  std::vector<std::string> apart;
  for (const NamePart word : words) {
    const auto ending = std::find_if(kEndings.begin(), kEndings.end(), [&](NamePart each) {
      return word.ends_with(each) &&
             std::find(kStems.begin(), kStems.end(), word.substr(0, word.size() - each.size())) !=
                 kStems.end();
    });
    if (ending == kEndings.end()) {
      apart.emplace_back(word);
    } else {
      apart.emplace_back(word.substr(0, word.size() - ending->size()));
      apart.emplace_back(*ending);
    }
  }
  return apart;
}

/// A name without its unit, as words.
class NameWords {
 public:
  explicit NameWords(NamePart name) : words_(WithAxisApart(SplitWords(name))) {}

  bool Any(Choices choices) const {
    return std::any_of(choices.begin(), choices.end(),
                       [this](NamePart choice) { return Is(choice); });
  }
  bool Is(NamePart word) const {
    return std::find(words_.begin(), words_.end(), word) != words_.end();
  }
  bool Only(NamePart word) const { return words_.size() == 1 && words_[0] == word; }

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
  std::vector<std::string> words_;
};

bool IsTimeUnit(const std::string& unit) {
  for (const NamePart each :
       {"s", "sec", "secs", "second", "seconds", "ms", "msec", "millisecond", "milliseconds", "us",
        "microsecond", "microseconds", "ns", "nanosecond", "nanoseconds"}) {
    if (unit == each) return true;
  }
  return false;
}

std::string TimeName(const NameWords& words, const std::string& unit) {
  if (words.Any({"week", "wk", "weekno", "gpsweek"}) &&
      !words.Any({"seconds", "sec", "secs", "of"})) {
    return "week";
  }
  const bool is_time =
      words.Any({"time", "timestamp", "t", "tow", "sow", "gpstime", "utctime", "itow",
                 "sampletimefine", "stamp", "seconds", "secs", "gpsseconds", "epoch"});
  if (!is_time || words.BodyAxis() != 0 || words.Any({"date", "datetime"}) ||
      (!unit.empty() && !IsTimeUnit(unit)))
    return {};
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

std::string InertialName(const NameWords& words) {
  const char axis = words.BodyAxis();
  if (axis == 0 || IsSigma(words) ||
      words.Any({"mag", "magnetic", "magnetometer", "covariance", "bias"})) {
    return {};
  }
  if (words.Any({"gyr", "gyro", "gyroscope", "gyros", "angular", "angularvelocity", "angularrate",
                 "omega", "w", "rate", "rot", "imugyro"})) {
    return std::string("w") + axis;
  }
  if (words.Any({"acc", "accel", "accelerometer", "acceleration", "accels", "force",
                 "specificforce", "f", "a"})) {
    return std::string("f") + axis;
  }
  // "gx" stands for a gyro beside "ax", and for nothing else.
  return words.Is("g") ? std::string("w") + axis : std::string();
}

std::string AttitudeName(const NameWords& words) {
  if (IsSigma(words)) return {};
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
  if (words.Any({"above", "separation", "sonar", "max"})) return {};
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

}  // namespace

ColumnMeaning FindMeaning(std::string_view column) {
  const std::string name = LowerCase(column);
  const std::size_t open = std::min(name.find_first_of("([{"), name.size());
  std::string unit;
  for (const char c : NamePart(name).substr(open)) {
    if (NamePart("([{}]) \t").find(c) == NamePart::npos) unit += c;
  }
  const NameWords words(NamePart(name).substr(0, open));
  if (const std::string time = TimeName(words, unit); !time.empty()) return {time, unit};
  for (const auto& find : {InertialName, AttitudeName, MapName}) {
    if (const std::string found = find(words); !found.empty()) return {found, unit};
  }
  return {"", unit};
}

}  // namespace dn::files_internal
