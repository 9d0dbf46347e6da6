#include <dn/geo/gps_time.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/median.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gnss_readers.h"

namespace dn::gnss_internal {
namespace {

// A value above this is not a time; whole weeks are computed from it.
constexpr double kMostTimeOfWeekS = 1e9;

using Fields = std::vector<std::string_view>;

Fields Split(std::string_view line) {
  constexpr std::string_view kSeparators = " \t,;\r";
  Fields fields;
  while (true) {
    const std::size_t begin = line.find_first_not_of(kSeparators);
    if (begin == std::string_view::npos) return fields;
    const std::size_t end = std::min(line.find_first_of(kSeparators, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

enum class TimeSystem { kGps, kUtc, kJapan };

/// Header of a .pos file: time system and names of the columns after the two columns of the time.
struct Header {
  TimeSystem time_system;
  /// Names without unit; latitude or longitude in deg, min, s counts once.
  std::vector<std::string> columns;
  bool degrees_minutes_seconds = false;

  std::optional<std::size_t> Find(const std::string& name) const {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end()) return std::nullopt;
    return static_cast<std::size_t>(found - columns.begin());
  }

  bool Has(const std::vector<std::string>& names) const {
    return std::all_of(names.begin(), names.end(),
                       [this](const std::string& name) { return Find(name).has_value(); });
  }
};

std::optional<TimeSystem> ParseTimeSystem(std::string_view label) {
  if (label == "GPST") return TimeSystem::kGps;
  if (label == "UTC") return TimeSystem::kUtc;
  if (label == "JST") return TimeSystem::kJapan;
  return std::nullopt;
}

void CheckCoordinates(const Header& header, const FileLocation& where) {
  if (header.Has({"latitude", "longitude", "height"})) return;
  if (header.Has({"x-ecef", "y-ecef", "z-ecef"})) return;
  throw InvalidInput(
      "columns are neither latitude, longitude, height nor x, y, z-ecef; write the solution with "
      "out-solformat llh or xyz",
      where);
}

/// Parses a comment line; returns nullopt unless it is the line that names the columns.
std::optional<Header> ParseHeader(std::string_view line, const FileLocation& where) {
  const Fields fields = Split(line.substr(1));
  if (fields.empty()) return std::nullopt;
  const std::optional<TimeSystem> time_system = ParseTimeSystem(fields[0]);
  if (!time_system) return std::nullopt;
  Header header{*time_system, {}};
  for (std::size_t i = 1; i < fields.size(); ++i) {
    const std::size_t unit = std::min(fields[i].find('('), fields[i].size());
    header.columns.emplace_back(fields[i].substr(0, unit));
    if (fields[i].substr(unit).starts_with("(d'")) header.degrees_minutes_seconds = true;
  }
  CheckCoordinates(header, where);
  return header;
}

/// Returns the header that fits a row of a complete solution, written without header lines; nullopt
/// for any other number of values. The options of RTKLIB append columns only in this order.
std::optional<Header> GuessHeader(const Fields& fields) {
  static const std::vector<std::string> kGeographic{"latitude", "longitude", "height"};
  static const std::vector<std::string> kEcef{"x-ecef", "y-ecef", "z-ecef"};
  constexpr std::size_t kTimes = 2, kPosition = 13, kWithVelocity = 22;
  const std::size_t values = fields.size() - std::min(fields.size(), kTimes);
  if (values != kPosition && values != kWithVelocity) return std::nullopt;
  double first = 0.0;
  std::from_chars(fields[2].data(), fields[2].data() + fields[2].size(), first);
  const bool ecef = std::abs(first) > 360.0;
  Header header{TimeSystem::kGps, ecef ? kEcef : kGeographic};
  const auto append = [&header](const char* names) {
    for (const std::string_view name : Split(names)) header.columns.emplace_back(name);
  };
  append(ecef ? "Q ns sdx sdy sdz sdxy sdyz sdzx age ratio"
              : "Q ns sdn sde sdu sdne sdeu sdun age ratio");
  if (values == kPosition) return header;
  append(ecef ? "vx vy vz sdvx sdvy sdvz sdvxy sdvyz sdvzx"
              : "vn ve vu sdvn sdve sdvu sdvne sdveu sdvun");
  return header;
}

void RejectOtherDatums(std::string_view line, const FileLocation& where) {
  constexpr std::string_view kKey = "lat/lon/height=";
  const std::size_t at = line.find(kKey);
  if (at == std::string_view::npos) return;
  if (line.substr(at + kKey.size()).starts_with("WGS84/ellipsoidal")) return;
  throw InvalidInput(
      "coordinates are not WGS84 with ellipsoidal heights; write the solution with out-height "
      "ellipsoidal",
      where);
}

long ParseInteger(std::string_view text, const FileLocation& where) {
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InvalidInput("'" + std::string(text) + "' is not an integer", where);
  }
  return value;
}

/// Splits a date or a time of day at `separator`. Throws unless it has three parts.
Fields SplitInThree(std::string_view text, char separator, const FileLocation& where) {
  Fields parts;
  std::string_view rest = text;
  for (std::size_t at; (at = rest.find(separator)) != std::string_view::npos;) {
    parts.push_back(rest.substr(0, at));
    rest.remove_prefix(at + 1);
  }
  parts.push_back(rest);
  if (parts.size() != 3) {
    throw InvalidInput("time '" + std::string(text) +
                           "' is neither year/month/day hour:minute:second nor week and seconds",
                       where);
  }
  return parts;
}

constexpr long kMostYear = 9999, kMostWeeks = 52 * kMostYear;

/// Parses a GPS week. Throws InvalidInput if no GPS time can have it.
long ParseWeek(std::string_view text, const FileLocation& where) {
  const long week = ParseInteger(text, where);
  if (week < 0 || week > kMostWeeks) {
    throw InvalidInput(
        "GPS week " + std::to_string(week) + " is outside 0 to " + std::to_string(kMostWeeks),
        where);
  }
  return week;
}

GpsTime ParseTime(std::string_view first, std::string_view second, const FileLocation& where) {
  if (first.find('/') == std::string_view::npos) {
    return {ParseWeek(first, where), ParseNumber(second, where)};
  }
  const Fields date = SplitInThree(first, '/', where);
  const Fields time = SplitInThree(second, ':', where);
  const auto integer = [&where](std::string_view text) {
    const long value = ParseInteger(text, where);
    if (value < 0 || value > kMostYear) {
      throw InvalidInput("'" + std::string(text) + "' is not part of a date or a time", where);
    }
    return static_cast<int>(value);
  };
  try {
    return CalendarToGpsTime(integer(date[0]), integer(date[1]), integer(date[2]), integer(time[0]),
                             integer(time[1]), ParseNumber(time[2], where));
  } catch (const InvalidInput& e) {
    if (e.where().line > 0) throw;
    throw InvalidInput(std::string(first) + " " + std::string(second) + ": " + e.what(), where);
  }
}

GpsTime ToGpsTime(GpsTime time, TimeSystem system) {
  constexpr double kJapanMinusUtcS = 9.0 * 3600.0;
  if (system == TimeSystem::kJapan) time.tow_s -= kJapanMinusUtcS;
  if (system != TimeSystem::kGps) time.tow_s += GpsMinusUtcS(time);
  return time;
}

/// Converts degrees, minutes, seconds to degrees. The sign of the degrees, including that of "-0",
/// applies to the whole angle.
double ParseDms(const std::string_view* parts, const FileLocation& where) {
  const double degrees = std::abs(ParseNumber(parts[0], where));
  const double minutes = ParseNumber(parts[1], where), seconds = ParseNumber(parts[2], where);
  const double angle_deg = degrees + minutes / 60.0 + seconds / 3600.0;
  return parts[0].starts_with('-') ? -angle_deg : angle_deg;
}

/// Collects the rows of a .pos file in a table. Column 0 contains the time in seconds from the
/// start of the first row's week; the header's columns follow.
class PosParser {
 public:
  explicit PosParser(const std::filesystem::path& file) { table_.file = file; }

  void ParseLine(std::string_view line) {
    ++line_;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos || line[begin] == '#') return;
    if (line[begin] == '%') {
      ParseComment(line.substr(begin));
    } else {
      ParseRow(Split(line));
    }
  }

  const Header& header() const { return *header_; }
  /// Number of rows before any header, whose columns and time system are assumed.
  long guessed_rows() const { return guessed_rows_; }
  TextTable& table() { return table_; }

 private:
  FileLocation Here() const { return {table_.file.string(), line_, 0}; }

  void ParseComment(std::string_view line) {
    RejectOtherDatums(line, Here());
    if (std::optional<Header> header = ParseHeader(line, Here())) {
      if (header_ && header_->columns != header->columns) {
        throw InvalidInput("columns change within the file", Here());
      }
      guessed_ = false;
      header_ = std::move(header);
      table_.columns = 1 + header_->columns.size();
    }
  }

  void ParseRow(const Fields& fields) {
    if (!header_) {
      header_ = GuessHeader(fields);
      guessed_ = header_.has_value();
      if (guessed_) table_.columns = 1 + header_->columns.size();
    }
    if (guessed_) ++guessed_rows_;
    if (!header_) {
      throw InvalidInput(
          "no line with the names of the columns ('%  GPST  latitude(deg) ...') before the first "
          "row; write the solution with out-outhead on",
          Here());
    }
    const std::size_t wanted =
        2 + header_->columns.size() + (header_->degrees_minutes_seconds ? 4 : 0);
    if (fields.size() != wanted) {
      throw InvalidInput("row has " + std::to_string(fields.size()) +
                             " values, but the header names " + std::to_string(wanted),
                         Here());
    }
    table_.values.push_back(Time(fields));
    ParseValues(fields);
    table_.lines.push_back(line_);
  }

  double Time(const Fields& fields) {
    const GpsTime time = ToGpsTime(ParseTime(fields[0], fields[1], Here()), header_->time_system);
    if (!(std::abs(time.tow_s) <= kMostTimeOfWeekS)) {
      throw InvalidInput("the time of week is beyond 1e9 s", Here());
    }
    if (table_.lines.empty()) {
      first_week_ = time.week + static_cast<long>(std::floor(time.tow_s / kWeekS));
    }
    const double t_s = kWeekS * static_cast<double>(time.week - first_week_) + time.tow_s;
    if (!table_.lines.empty() && t_s < table_.row(table_.rows() - 1)[0]) {
      throw InvalidInput("time does not increase: it is earlier than that of the row before",
                         Here());
    }
    return t_s;
  }

  void ParseValues(const Fields& fields) {
    std::size_t at = 2;
    for (const std::string& name : header_->columns) {
      const bool three_parts =
          header_->degrees_minutes_seconds && (name == "latitude" || name == "longitude");
      table_.values.push_back(three_parts ? ParseDms(&fields[at], Here())
                                          : ParseNumber(fields[at], Here()));
      at += three_parts ? 3 : 1;
    }
  }

  TextTable table_;
  std::optional<Header> header_;
  bool guessed_ = false;
  long guessed_rows_ = 0;
  long line_ = 0;
  long first_week_ = 0;
};

/// Gives access to the values of one row by column name.
class Row {
 public:
  Row(const Header& header, const double* row) : header_(header), row_(row) {}

  double operator()(const std::string& name) const { return row_[1 + *header_.Find(name)]; }
  Eigen::Vector3d Triple(const std::vector<std::string>& names) const {
    return {(*this)(names[0]), (*this)(names[1]), (*this)(names[2])};
  }
  bool Has(const std::vector<std::string>& names) const { return header_.Has(names); }

 private:
  const Header& header_;
  const double* row_;
};

/// Column names of one quantity in one coordinate form. The signed roots belong to the pairs 01,
/// 12, 20 of the axes.
struct Names {
  std::string axes;
  std::vector<std::string> value, sigma, signed_root;
};

const Names kPositionEnu{"ENU", {}, {"sde", "sdn", "sdu"}, {"sdne", "sdun", "sdeu"}};
const Names kPositionXyz{
    "xyz", {"x-ecef", "y-ecef", "z-ecef"}, {"sdx", "sdy", "sdz"}, {"sdxy", "sdyz", "sdzx"}};
const Names kVelocityEnu{
    "ENU", {"ve", "vn", "vu"}, {"sdve", "sdvn", "sdvu"}, {"sdvne", "sdvun", "sdveu"}};
const Names kVelocityXyz{
    "xyz", {"vx", "vy", "vz"}, {"sdvx", "sdvy", "sdvz"}, {"sdvxy", "sdvyz", "sdvzx"}};

Eigen::Matrix3d Covariance(const Row& row, const Names& names, const std::string& what,
                           const FileLocation& where) {
  const Eigen::Vector3d sigma = row.Triple(names.sigma);
  CheckSigmas(sigma, what, names.axes, where);
  const Eigen::Vector3d roots =
      row.Has(names.signed_root) ? row.Triple(names.signed_root) : Eigen::Vector3d(0.0, 0.0, 0.0);
  return SignedRootsToCovariance(sigma, roots);
}

/// Converts the quality of a solution (1 fixed, 2 float, 4 code differences, 5 single, ...) to an
/// integer. Throws InvalidInput if `value` is not such an integer.
int Quality(double value, const FileLocation& where) {
  constexpr double kMost = 255.0;
  if (value < 0.0 || value > kMost || value != std::floor(value)) {
    throw InvalidInput("the quality Q is not an integer between 0 and 255", where);
  }
  return static_cast<int>(value);
}

GnssEpoch MakeEpoch(const Row& row, const FileLocation& where) {
  GnssEpoch epoch;
  epoch.line = where.line;
  if (row.Has({"Q"})) epoch.quality = Quality(row("Q"), where);
  const bool is_xyz = row.Has(kPositionXyz.value);
  if (is_xyz) {
    epoch.antenna = GeodeticFromEcef(row.Triple(kPositionXyz.value));
  } else {
    epoch.antenna = {row("latitude") * kRadPerDeg, row("longitude") * kRadPerDeg, row("height")};
  }
  CheckGeodetic(epoch.antenna, where);

  const Eigen::Matrix3d R_enu_axes =
      is_xyz ? Eigen::Matrix3d(R_e_enu(epoch.antenna).transpose()) : Eigen::Matrix3d::Identity();
  const Names& position = is_xyz ? kPositionXyz : kPositionEnu;
  if (row.Has(position.sigma) && !row.Triple(position.sigma).isZero(0.0)) {
    epoch.covariance_enu_m2 =
        R_enu_axes * Covariance(row, position, "position", where) * R_enu_axes.transpose();
  }
  const Names& velocity = is_xyz ? kVelocityXyz : kVelocityEnu;
  if (row.Has(velocity.value) && row.Has(velocity.sigma)) {
    const bool estimated = !row.Triple(velocity.sigma).isZero(0.0);
    if (estimated) {
      epoch.velocity_enu_mps = R_enu_axes * row.Triple(velocity.value);
      CheckVelocity(*epoch.velocity_enu_mps, where);
      epoch.velocity_covariance_enu =
          R_enu_axes * Covariance(row, velocity, "velocity", where) * R_enu_axes.transpose();
    }
  }
  return epoch;
}

/// Throws InvalidInput if rows without a header move as degrees never do: they are baselines east,
/// north, up in m.
void RejectBaselines(const std::vector<GnssEpoch>& epochs, const std::filesystem::path& file) {
  constexpr double kMostSpeedMps = 1000.0;
  std::vector<double> speeds_mps;
  for (std::size_t i = 1; i < epochs.size(); ++i) {
    const double step_s = epochs[i].t_s - epochs[i - 1].t_s;
    const LocalFrame frame(epochs[i - 1].antenna);
    speeds_mps.push_back(frame.ToMap(epochs[i].antenna).norm() / step_s);
  }
  if (speeds_mps.empty() || Median(speeds_mps) < kMostSpeedMps) return;
  throw InvalidInput(
      "the rows have no header and are no latitude and longitude: as degrees they move by more "
      "than 1000 m/s; if they are baselines in m, write the solution with out-solformat llh or xyz "
      "and out-outhead on",
      {file.string(), epochs.front().line, 0});
}

}  // namespace

GnssData ReadRtklibPos(const std::filesystem::path& file, double time_offset_s) {
  PosParser parser(file);
  LineReader lines(file);
  for (std::string_view line; lines.Next(&line);) parser.ParseLine(line);
  TextTable& table = parser.table();
  if (table.rows() == 0) throw InvalidInput("file has no solutions", {file.string(), 0, 0});

  std::vector<std::size_t> keep;
  GnssData data;
  data.Count("gnss rows without a header, read as GPS time", parser.guessed_rows());
  data.repeated_rows_dropped = ContinueAndCheckTimes(table, keep, time_offset_s);
  data.epochs.reserve(keep.size());
  for (const std::size_t i : keep) {
    const Row row(parser.header(), table.row(i));
    data.epochs.push_back(MakeEpoch(row, {file.string(), table.lines[i], 0}));
    data.epochs.back().t_s = table.row(i)[0];
  }
  if (parser.guessed_rows() > 0) RejectBaselines(data.epochs, file);
  return data;
}

}  // namespace dn::gnss_internal
