#include <dn/geo/little_endian.h>
#include <dn/names.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "las_file.h"

namespace dn::lidar_internal {
namespace {

constexpr int kGeographicWgs84 = 4326, kGeocentricWgs84 = 4978;
constexpr std::size_t kMostText = 200;

std::string Utm(int zone, bool south) {
  return "utm:" + std::to_string(zone) + (south ? "s" : "n");
}

/// Returns the name in strips_crs of a system on WGS84, ETRS89 or NAD83 (which differ by less than
/// 3 m); empty for other systems.
std::string EpsgName(int epsg) {
  const int zone = epsg % 100;
  const auto utm = [&](int first, int from, int to) {
    return epsg - zone == first && zone >= from && zone <= to;
  };
  if (epsg == kGeocentricWgs84 || epsg == 4936) return "ecef";
  if (utm(32600, 1, 60)) return Utm(zone, false);
  if (utm(32700, 1, 60)) return Utm(zone, true);
  if (utm(25800, 28, 38) || utm(26900, 1, 23)) return Utm(zone, false);
  return {};
}

[[noreturn]] void FailUnit(const char* what, const FileLocation& where) {
  throw InvalidInput(
      std::string("the ") + what +
          " of the points are not in metres, by the coordinate system in the header; "
          "convert them to UTM (in metres) or ECEF",
      where);
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
constexpr int kMetre = 9001, kUserDefined = 32767;

std::optional<int> FindEpsg(const GeoKeys& keys, std::size_t key) {
  const std::optional<int> code = keys.Number(key);
  return code && *code >= 1024 && *code != kUserDefined ? code : std::nullopt;
}

void ReadProjected(const GeoKeys& keys, StripCrs* crs) {
  crs->epsg = FindEpsg(keys, kProjectedKey);
  if (crs->epsg) {
    crs->name = EpsgName(*crs->epsg);
    return;
  }
  // A projection without a coordinate system: 160zz is UTM north and 161zz is UTM south.
  const int projection = keys.Number(kProjectionKey).value_or(0);
  const int zone = projection % 100;
  if (projection / 200 == 80 && zone >= 1 && zone <= 60) crs->name = Utm(zone, projection >= 16100);
}

void CheckUnit(const GeoKeys& keys, std::size_t key, const char* what, const FileLocation& where) {
  const std::optional<int> unit = keys.Number(key);
  if (unit && *unit != kMetre && *unit != kUserDefined && *unit != 0) FailUnit(what, where);
}

/// Returns whether a vertical coordinate system of EPSG has heights in feet.
bool IsInFeet(int vertical) {
  constexpr std::array<int, 11> kInFeet{5702, 6130, 6131, 6132, 6358, 6360,
                                        8050, 8051, 8052, 8053, 8228};
  return std::find(kInFeet.begin(), kInFeet.end(), vertical) != kInFeet.end();
}

/// Reads the vertical system of the keys; returns whether heights refer to a geoid. Throws
/// InvalidInput for heights in feet.
bool ReadVertical(const GeoKeys& keys, const FileLocation& where) {
  CheckUnit(keys, kVerticalUnitKey, "heights", where);
  const int vertical = keys.Number(kVerticalKey).value_or(0);
  if (IsInFeet(vertical)) FailUnit("heights", where);
  // Vertical codes from 5001 to 5033 are ellipsoids.
  return vertical >= 1024 && vertical != kUserDefined && !(vertical >= 5001 && vertical <= 5033);
}

/// Reads well-known text and returns EPSG code, unit and name of its outermost horizontal system.
class WktReader {
 public:
  WktReader(std::string_view text, const FileLocation& where) : text_(text), where_(where) {}

  StripCrs Read() {
    for (std::size_t at = 0; at < text_.size();) at = Step(at);
    crs_.text = WithoutControls(text_.substr(0, kMostText));
    if (crs_.epsg) crs_.name = EpsgName(*crs_.epsg);
    if (crs_.name.empty()) crs_.name = TitleToName();
    return crs_;
  }

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

  void ExpectMetres(const Node& unit, const char* what) const {
    double factor = 0.0;
    const std::string& text = unit.values[1];
    const auto result = std::from_chars(text.data(), text.data() + text.size(), factor);
    if (result.ec == std::errc() && std::abs(factor - 1.0) > 1e-9) FailUnit(what, where_);
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
  FileLocation where_;
  StripCrs crs_;
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
    ReadProjected(keys, &crs);
    CheckUnit(keys, kUnitKey, "coordinates", where);
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
  return WktReader(text, where).Read();
}

bool ParseVerticalKeys(std::string_view directory, std::string_view ascii,
                       const FileLocation& where) {
  return ReadVertical(GeoKeys(directory, ascii, where), where);
}

}  // namespace dn::lidar_internal
