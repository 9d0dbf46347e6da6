#include <dn/geo/little_endian.h>
#include <dn/geo/point_crs.h>
#include <dn/names.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "las_file.h"

namespace dn::lidar_internal {
namespace {

constexpr int kGeographicWgs84 = 4326, kGeocentricWgs84 = 4978;
constexpr std::size_t kMostText = 200, kLongestWkt = 20000;

/// Returns the name of a zone, 1 to 60.
std::string Utm(int zone, bool south) {
  return ShortCrsName("epsg:" + std::to_string((south ? 32700 : 32600) + zone));
}

[[noreturn]] void FailUnit(const char* what, const FileLocation& where) {
  throw InvalidInput(
      std::string("the ") + what +
          " of the points are not in metres, by the coordinate system in the header; "
          "PROJ does not know the system; convert them to UTM (in metres) or ECEF",
      where);
}

constexpr double kUnitRounding = 1e-9;

/// Takes what PROJ finds about a system, if it knows the system.
void TakeName(const NamedCrs& named, StripCrs* crs) {
  if (named.name.empty()) return;
  crs->name = named.name;
  if (named.epsg) crs->epsg = named.epsg;
  crs->heights_from_geoid = named.heights_from_geoid;
  crs->why_not = named.why_not;
  crs->in_metres = named.in_metres;
}

/// Access to GeoTIFF keys by number, for keys with the value in the directory or in the ASCII
/// record.
class GeoKeys {
 public:
  GeoKeys(std::string_view directory, std::string_view ascii, const FileLocation& where)
      : directory_(directory), ascii_(ascii) {
    constexpr std::size_t kEntryBytes = 8;
    count_ = directory.size() < kEntryBytes ? 0 : Word(3);
    if (directory.size() < kEntryBytes * (1 + count_)) {
      throw InvalidInput("LAS header: the GeoTIFF directory announces " + std::to_string(count_) +
                             " keys, but its record has " + std::to_string(directory.size()) +
                             " bytes",
                         where);
    }
  }

  std::optional<int> Number(std::size_t key) const {
    const std::size_t at = Find(key, 0);
    return at == 0 ? std::nullopt : std::optional(static_cast<int>(Word(at + 3)));
  }

  std::string Text(std::size_t key) const {
    constexpr std::size_t kAscii = 34737;
    const std::size_t at = Find(key, kAscii);
    if (at == 0 || Word(at + 3) > ascii_.size()) return {};
    const std::string_view text = ascii_.substr(Word(at + 3), Word(at + 2));
    return WithoutControls(text.substr(0, text.find_first_of(std::string_view("|\0", 2))));
  }

 private:
  std::size_t Word(std::size_t index) const {
    return LoadLittleEndian<std::uint16_t>(directory_.data() + 2 * index);
  }

  /// Returns the first word of a key whose value is stored at `location`; 0 if there is no such
  /// key.
  std::size_t Find(std::size_t key, std::size_t location) const {
    for (std::size_t i = 1; i <= count_; ++i) {
      if (Word(4 * i) == key && Word(4 * i + 1) == location) return 4 * i;
    }
    return 0;
  }

  std::string_view directory_, ascii_;
  std::size_t count_ = 0;
};

constexpr std::size_t kModelKey = 1024, kCitationKey = 1026, kGeographicKey = 2048,
                      kProjectedKey = 3072, kProjectedCitationKey = 3073, kProjectionKey = 3074,
                      kUnitKey = 3076, kVerticalKey = 4096, kVerticalUnitKey = 4099;
constexpr int kProjectedModel = 1, kGeographicModel = 2, kGeocentricModel = 3;
constexpr int kMetre = 9001, kFoot = 9002, kSurveyFoot = 9003, kUserDefined = 32767;

std::optional<int> FindEpsg(const GeoKeys& keys, std::size_t key) {
  const std::optional<int> code = keys.Number(key);
  return code && *code >= 1024 && *code != kUserDefined ? code : std::nullopt;
}

/// Returns metres per unit of a key; nullopt without the key. Throws InvalidInput for a unit that
/// is neither metre nor foot.
std::optional<double> FindUnit(const GeoKeys& keys, std::size_t key, const char* what,
                               const FileLocation& where) {
  const int unit = keys.Number(key).value_or(0);
  if (unit == 0 || unit == kUserDefined) return std::nullopt;
  if (unit == kFoot) return kFootM;
  if (unit == kSurveyFoot) return kUsSurveyFootM;
  if (unit != kMetre) FailUnit(what, where);
  return 1.0;
}

std::optional<int> FindVertical(const GeoKeys& keys) {
  // Vertical codes from 5001 to 5033 are ellipsoids.
  const std::optional<int> code = FindEpsg(keys, kVerticalKey);
  return code && *code >= 5001 && *code <= 5033 ? std::nullopt : code;
}

/// Reads a projected system, which PROJ names if it has a code.
void ReadProjected(const GeoKeys& keys, const FileLocation& where, StripCrs* crs) {
  const std::optional<double> unit_m = FindUnit(keys, kUnitKey, "coordinates", where),
                              height_m = FindUnit(keys, kVerticalUnitKey, "heights", where);
  crs->epsg = FindEpsg(keys, kProjectedKey);
  if (crs->epsg) {
    const std::string horizontal = "EPSG:" + std::to_string(*crs->epsg);
    const double own_m = CrsUnitM(horizontal).value_or(1.0);
    if (unit_m && std::abs(*unit_m - own_m) > kUnitRounding) FailUnit("coordinates", where);
    const std::optional<int> vertical = FindVertical(keys);
    TakeName(NameCrs(horizontal + (vertical ? "+" + std::to_string(*vertical) : ""), height_m),
             crs);
    if (!crs->name.empty() || !height_m || *height_m == 1.0) return;
    FailUnit("heights", where);
  }
  if (unit_m.value_or(1.0) != 1.0) FailUnit("coordinates", where);
  if (height_m.value_or(1.0) != 1.0) FailUnit("heights", where);
  // A projection without a coordinate system: 160zz is UTM north and 161zz is UTM south.
  const int projection = keys.Number(kProjectionKey).value_or(0);
  const int zone = projection % 100;
  if (projection / 200 == 80 && zone >= 1 && zone <= 60) crs->name = Utm(zone, projection >= 16100);
}

/// Returns whether a vertical coordinate system of EPSG has heights in feet.
bool IsInFeet(int vertical) {
  const std::string any_horizontal = "EPSG:32632+";
  return !NameCrs(any_horizontal + std::to_string(vertical)).in_metres;
}

/// Reads the vertical system of the keys; returns whether heights refer to a geoid. Throws
/// InvalidInput for heights in feet.
bool ReadVertical(const GeoKeys& keys, const FileLocation& where) {
  const std::optional<int> vertical = FindVertical(keys);
  const double unit_m = FindUnit(keys, kVerticalUnitKey, "heights", where).value_or(1.0);
  if (unit_m != 1.0 || (vertical && IsInFeet(*vertical))) FailUnit("heights", where);
  return vertical.has_value();
}

/// Reads well-known text, which need not be complete, and returns EPSG code and name of its
/// outermost horizontal system.
class WktReader {
 public:
  explicit WktReader(std::string_view text) : text_(text) {}

  StripCrs Read() {
    for (std::size_t at = 0; at < text_.size();) at = Step(at);
    crs_.text = WithoutControls(text_.substr(0, kMostText));
    if (crs_.epsg) {
      const std::string code = "epsg:" + std::to_string(*crs_.epsg), name = ShortCrsName(code);
      if (name != code) crs_.name = name;
    }
    if (crs_.name.empty()) crs_.name = TitleToName();
    return crs_;
  }

  /// Returns what is not in metres: "coordinates" or "heights"; null if all is.
  const char* not_in_metres() const { return not_in_metres_; }

 private:
  struct Node {
    std::string keyword;
    std::vector<std::string> values;
  };

  static bool IsHorizontal(const std::string& keyword) {
    static const std::vector<std::string> words{"PROJCS", "PROJCRS", "PROJECTEDCRS",
                                                "GEOCCS", "GEODCRS", "GEODETICCRS",
                                                "GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"};
    return std::find(words.begin(), words.end(), keyword) != words.end();
  }

  static bool IsVertical(const std::string& keyword) {
    return keyword == "VERT_CS" || keyword == "VERTCS" || keyword == "VERTCRS" ||
           keyword == "VERTICALCRS";
  }

  /// Reads one token at position `at` and returns the position after it.
  std::size_t Step(std::size_t at) {
    const char c = text_[at];
    if (c == '"') return Quoted(at);
    if (c == '[' || c == '(') {
      horizontal_ += IsHorizontal(word_) ? 1 : 0;
      nodes_.push_back({word_, {}});
      word_.clear();
      return at + 1;
    }
    if (c == ']' || c == ')' || c == ',') {
      if (!word_.empty() && !nodes_.empty()) nodes_.back().values.push_back(word_);
      word_.clear();
      if (c != ',' && !nodes_.empty()) Close();
      return at + 1;
    }
    if (std::isspace(static_cast<unsigned char>(c)) == 0) {
      word_ += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
    return at + 1;
  }

  std::size_t Quoted(std::size_t at) {
    const std::size_t end = std::min(text_.find('"', at + 1), text_.size());
    if (!nodes_.empty()) nodes_.back().values.emplace_back(text_.substr(at + 1, end - at - 1));
    return end + 1;
  }

  void Close() {
    const Node node = std::move(nodes_.back());
    nodes_.pop_back();
    horizontal_ -= IsHorizontal(node.keyword) ? 1 : 0;
    if (IsVertical(node.keyword)) crs_.heights_from_geoid = true;
    if (nodes_.empty() || node.values.size() < 2) return;
    const Node& parent = nodes_.back();
    const bool unit = node.keyword == "UNIT" || node.keyword == "LENGTHUNIT";
    if (unit && IsVertical(parent.keyword)) ExpectMetres(node, "heights");
    if (!IsHorizontal(parent.keyword) || horizontal_ != 1) return;
    if (title_.empty() && !parent.values.empty()) title_ = parent.values.front();
    const bool linear = parent.keyword.starts_with("PROJ") || parent.keyword == "GEOCCS";
    if (unit && linear) ExpectMetres(node, "coordinates");
    if (node.keyword == "AUTHORITY" || node.keyword == "ID") ReadCode(node);
  }

  void ExpectMetres(const Node& unit, const char* what) {
    double factor = 0.0;
    const std::string& text = unit.values[1];
    const auto result = std::from_chars(text.data(), text.data() + text.size(), factor);
    if (result.ec == std::errc() && std::abs(factor - 1.0) > kUnitRounding) not_in_metres_ = what;
  }

  void ReadCode(const Node& node) {
    const std::string& text = node.values[1];
    int code = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), code);
    if (node.values[0] == "EPSG" && result.ec == std::errc()) crs_.epsg = code;
  }

  /// Recognises a title such as "WGS 84 / UTM zone 11N", for text without an EPSG code.
  std::string TitleToName() const {
    constexpr std::string_view kPhrase = "UTM zone ";
    const std::size_t at = title_.find(kPhrase);
    if (at == std::string::npos) return {};
    const char* digits = title_.data() + at + kPhrase.size();
    const char* end = title_.data() + title_.size();
    int zone = 0;
    const auto result = std::from_chars(digits, end, zone);
    if (result.ec != std::errc() || zone < 1 || zone > 60 || result.ptr == end) return {};
    if (*result.ptr != 'N' && *result.ptr != 'S') return {};
    return Utm(zone, *result.ptr == 'S');
  }

  std::string_view text_;
  StripCrs crs_;
  const char* not_in_metres_ = nullptr;
  std::string word_;
  std::string title_;
  std::vector<Node> nodes_;
  long horizontal_ = 0;  ///< number of horizontal systems among nodes_
};

}  // namespace

StripCrs ParseGeoTiff(std::string_view directory, std::string_view ascii,
                      const FileLocation& where) {
  const GeoKeys keys(directory, ascii, where);
  StripCrs crs;
  crs.text = keys.Text(kProjectedCitationKey);
  if (crs.text.empty()) crs.text = keys.Text(kCitationKey);
  const int model = keys.Number(kModelKey).value_or(0);
  if (model == kProjectedModel) {
    ReadProjected(keys, where, &crs);
    if (!crs.name.empty() && crs.epsg) return crs;
  } else if (model == kGeographicModel) {
    crs.epsg = FindEpsg(keys, kGeographicKey);
  } else if (model == kGeocentricModel) {
    const int datum = keys.Number(kGeographicKey).value_or(0);
    if (datum == kGeographicWgs84 || datum == kGeocentricWgs84) crs.epsg = kGeocentricWgs84;
    crs.name = "ecef";
  }
  crs.heights_from_geoid = ReadVertical(keys, where);
  return crs;
}

StripCrs ParseWkt(std::string_view text, const FileLocation& where) {
  WktReader reader(text);
  StripCrs crs = reader.Read();
  const NamedCrs named = text.size() <= kLongestWkt ? NameCrs(std::string(text)) : NamedCrs();
  const bool converted = !named.name.empty() && !named.in_metres;
  if (reader.not_in_metres() != nullptr && !converted) FailUnit(reader.not_in_metres(), where);
  TakeName(named, &crs);
  return crs;
}

bool ParseVerticalKeys(std::string_view directory, std::string_view ascii,
                       const FileLocation& where) {
  return ReadVertical(GeoKeys(directory, ascii, where), where);
}

}  // namespace dn::lidar_internal
