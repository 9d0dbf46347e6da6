#include "gnss_content.h"

#include <dn/geo/text_fields.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "picked_columns.h"
#include "plausible_motion.h"

namespace dn::files_internal {
namespace {

// GNSS receivers have at most this rate, inertial sensors a higher one.
constexpr double kMostGnssHz = 25.0;
constexpr StepRange kGnssSteps{1.0 / kMostGnssHz - 1e-3, 120.0, 0.5};
constexpr double kMostSigmaM = 1000.0;
constexpr double kMostHeightM = 2e4;
constexpr double kRadian = 180.0 / std::numbers::pi;
constexpr std::array<const char*, 3> kPosition{"lat", "lon", "h"};
constexpr std::array<const char*, 3> kSigma{"sigma_e", "sigma_n", "sigma_u"};
constexpr std::array<const char*, 3> kVelocity{"ve", "vn", "vu"};
constexpr std::array<const char*, 3> kVelocitySigma{"sigma_ve", "sigma_vn", "sigma_vu"};

using TripleNames = std::array<const char*, 3>;

bool ArePositive(const double* values) {
  return std::all_of(values, values + 3, [](double x) { return x > 0.0 && x < kMostSigmaM; });
}

bool AreZero(const double* values) {
  return std::all_of(values, values + 3, [](double x) { return x == 0.0; });
}

/// Returns the distance between two places in degrees of latitude. The longitude may jump by 360
/// deg, and near a pole its differences are short.
double StepDeg(const double* a, const double* b) {
  const double lon = std::remainder(b[2] - a[2], 360.0);
  return std::hypot(b[1] - a[1], lon * std::cos(b[1] / kRadian));
}

/// Returns whether columns 2 to 4 can be latitude, longitude and height with a plausible speed. The
/// first two may be exchanged, or in radians.
bool AreCoordinates(const TextTable& table) {
  const double limit_deg = 0.01 + 60.0 * kMostSpeedMps / kMetresPerDeg;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* row = table.row(i);
    if (std::abs(row[1]) > 360.0 || std::abs(row[2]) > 360.0) return false;
    if (std::abs(row[3]) > kMostHeightM) return false;
    if (i > 0 && StepDeg(table.row(i - 1), row) > limit_deg) return false;
  }
  return true;
}

/// Returns whether the longitude comes first, which is certain only beyond 90 deg.
bool IsLongitudeFirst(const TextTable& table) {
  bool beyond = false;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (std::abs(table.row(i)[2]) > 90.0) return false;
    beyond = beyond || std::abs(table.row(i)[1]) > 90.0;
  }
  return beyond;
}

/// Columns of a choice: a position, perhaps more triples, and columns that are added to others.
struct GnssChoice {
  std::vector<NamedColumn> position, rest, added = {};
  std::string note = {};  ///< what is uncertain about the columns
  double prior = 1.0;
  bool is_named = false;
};

std::optional<std::vector<NamedColumn>> FindTriple(const std::vector<ColumnMeaning>& meanings,
                                                   const TripleNames& names) {
  std::vector<NamedColumn> columns;
  for (const std::string name : names) {
    std::optional<NamedColumn> column = FindColumn(meanings, name);
    if (!column && name.ends_with('u')) {
      column = FindColumn(meanings, name.substr(0, name.size() - 1) + "d");
    }
    if (!column) return std::nullopt;
    columns.push_back(*column);
  }
  return columns;
}

void AppendTriple(const std::optional<std::vector<NamedColumn>>& triple,
                  std::vector<NamedColumn>* to) {
  if (triple) to->insert(to->end(), triple->begin(), triple->end());
}

/// Altitudes are above the ellipsoid in some programs, above the sea or the ground in others.
std::string AltitudeNote(const std::string& name) {
  const auto has = [&](const char* part) { return name.find(part) != name.npos; };
  const bool altitude = (has("alt") || has("Alt") || has("ALT")) && !has("llips") && !has("LLIPS");
  return altitude ? "make sure that '" + name + "' is above the ellipsoid" : std::string();
}

std::optional<GnssChoice> NamedGnssChoice(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  auto position = FindTriple(meanings, kPosition);
  const auto undulation = FindColumn(meanings, "undulation");
  const bool above_sea = !position && undulation;
  if (above_sea) position = FindTriple(meanings, {"lat", "lon", "h_msl"});
  if (!position) return std::nullopt;
  GnssChoice choice{*position, {}};
  choice.is_named = true;
  choice.added = FindMinutes(meanings);
  if (above_sea) {
    choice.position.back().name = "h";
    choice.added.push_back(*undulation);
  }
  for (int i = 0; i < 2; ++i) {
    NamedColumn& angle = choice.position[static_cast<std::size_t>(i)];
    if (meanings[angle.at].unit.starts_with("rad")) angle.name += "_rad";
  }
  if (!above_sea) choice.note = AltitudeNote(sample.names[choice.position.back().at]);
  AppendTriple(FindTriple(meanings, kSigma), &choice.rest);
  const auto velocity = FindTriple(meanings, kVelocity);
  const auto sigma = FindTriple(meanings, kVelocitySigma);
  if (velocity && sigma) {
    AppendTriple(velocity, &choice.rest);
    AppendTriple(sigma, &choice.rest);
  }
  return choice;
}

/// Returns the columns by their number: those of the documented formats, else only the position.
GnssChoice GnssChoiceByCount(const TextSample& sample, const TimeColumn& time) {
  const std::size_t first = std::max(time.at, time.week.value_or(0)) + 1;
  GnssChoice choice;
  std::size_t at = first;
  const auto take = [&at](const TripleNames& names, std::vector<NamedColumn>* to) {
    for (const char* name : names) to->push_back({name, at++});
  };
  take(kPosition, &choice.position);
  const std::size_t rest = sample.table.columns - std::min(sample.table.columns, at);
  if (rest == 3 || rest == 9) take(kSigma, &choice.rest);
  if (rest == 6 || rest == 9) {
    take(kVelocity, &choice.rest);
    take(kVelocitySigma, &choice.rest);
  }
  if (rest > 0 && choice.rest.empty()) choice.prior = 0.6;
  return choice;
}

bool IsPlainGnss(const TextSample& sample, const TimeColumn& time, const GnssChoice& choice) {
  if (sample.needs_names || time.week || time.at != 0 || time.name != "t") return false;
  std::size_t at = 1;
  for (const NamedColumn& column : choice.position) {
    if (column.at != at++) return false;
  }
  for (const NamedColumn& column : choice.rest) {
    if (column.at != at++) return false;
  }
  return sample.table.columns == at && choice.position[0].name == "lat";
}

/// Returns whether three columns of every row pass a test.
template <class Test>
bool EveryRowPasses(const TextTable& table, std::size_t at, const Test& test) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!test(table.row(i) + at)) return false;
  }
  return true;
}

/// Describes sigmas and velocities of canonical columns. In one of the two formats with 13 columns
/// the sigmas come first, in the other the velocity.
void DescribeGnss(const TextTable& table, bool plain, FileContent* content) {
  content->has_velocity = table.columns >= 10;
  const bool sigma_column = table.columns == 7 || table.columns == 13;
  content->has_sigma = sigma_column && !EveryRowPasses(table, 4, AreZero);
  if (!plain || table.columns != 13) return;
  if (!EveryRowPasses(table, 4, ArePositive) && EveryRowPasses(table, 7, ArePositive)) {
    content->gnss_format = GnssFormat::kObGins;
  }
}

/// Returns whether the header, if there is one, lets the columns be a position: it names one of
/// them so, and none as another quantity.
bool MayBePosition(const std::vector<ColumnMeaning>& meanings,
                   const std::vector<NamedColumn>& position) {
  if (meanings.empty()) return true;
  const auto is_position = [&](const NamedColumn& column) {
    if (column.at >= meanings.size()) return false;
    const std::string& name = meanings[column.at].name;
    return name == "lat" || name == "lon" || name == "h" || name == "h_msl";
  };
  return std::any_of(position.begin(), position.end(), is_position) &&
         std::all_of(position.begin(), position.end(), [&](const NamedColumn& column) {
           return is_position(column) || IsUnnamed(meanings, column.at);
         });
}

/// Returns whether latitude and longitude have the same values in all of several rows.
bool StandsStill(const TextTable& table) {
  for (std::size_t i = 1; i < table.rows(); ++i) {
    if (table.row(i)[1] != table.row(0)[1] || table.row(i)[2] != table.row(0)[2]) return false;
  }
  return table.rows() > 1;
}

ContentFit FitGnssChoice(const TextSample& sample, const TimeColumn& time, GnssChoice choice) {
  FileContent content;
  content.kind = FileKind::kGnss;
  FitTests tests(5.0);
  std::vector<NamedColumn> all = choice.position;
  all.insert(all.end(), choice.rest.begin(), choice.rest.end());
  const bool has_columns = std::all_of(all.begin(), all.end(), [&](const NamedColumn& column) {
    return column.at < sample.table.columns;
  });
  if (!tests.Expect(has_columns, "fewer than 4 columns")) return tests.Result(content);
  TextTable table = PickRows(sample, time, all);
  if (!tests.Expect(AreNumbers(table, sample), "the columns contain text"))
    return tests.Result(content);
  content.time_offset_s = FindTimeOffset(table.row(0)[0]);
  // A documented format may be at rest; otherwise constant columns may be anything.
  const bool is_certain = choice.is_named || (sample.names.empty() && choice.prior == 1.0);
  tests.Expect(is_certain || !StandsStill(table),
               "the columns after the time are constant, and no header names them as a position");
  tests.Expect(AreCoordinates(table),
               "no latitude, longitude and height with a speed below 1000 m/s");
  const std::size_t last = table.columns - 3;
  const auto are_sigmas = [](const double* s) { return ArePositive(s) || AreZero(s); };
  tests.Expect(choice.rest.empty() || EveryRowPasses(table, last, are_sigmas),
               "the last three columns are not sigmas");
  if (choice.position[0].name == "lat" && IsLongitudeFirst(table)) {
    std::swap(choice.position[0].name, choice.position[1].name);
    content.why = "the longitude comes before the latitude";
  }
  if (content.why.empty()) content.why = choice.note;
  const bool plain = IsPlainGnss(sample, time, choice);
  DescribeGnss(table, plain, &content);
  if (!plain) {
    all = choice.position;
    all.insert(all.end(), choice.rest.begin(), choice.rest.end());
    all.insert(all.end(), choice.added.begin(), choice.added.end());
    content.columns = FormatNames(time, all);
  }
  ContentFit fit = tests.Result(std::move(content));
  fit.score *= choice.prior;
  return fit;
}

/// Returns whether a line names the columns of an RTKLIB solution.
bool IsRtklibHeader(std::string_view line) {
  if (!line.starts_with('%')) return false;
  const bool clock = line.find("GPST") != line.npos || line.find("UTC") != line.npos ||
                     line.find("JST") != line.npos;
  return clock && (line.find("latitude(") != line.npos || line.find("x-ecef(") != line.npos ||
                   line.find("e-baseline(") != line.npos);
}

/// Returns whether a line is a complete row of an RTKLIB solution. It begins with a calendar date
/// or a GPS week, and has a quality from 1 to 7.
bool IsRtklibRow(std::string_view line) {
  const std::vector<std::string_view> fields = SplitFields(line);
  if (fields.size() != 15 && fields.size() != 24) return false;
  const bool calendar = std::count(fields[0].begin(), fields[0].end(), '/') == 2 &&
                        std::count(fields[1].begin(), fields[1].end(), ':') == 2;
  const bool week = fields[0].size() == 4 && FieldNumber(fields[0]) && FieldNumber(fields[1]);
  const bool quality = fields[5].size() == 1 && fields[5][0] >= '1' && fields[5][0] <= '7';
  return (calendar || week) && quality;
}

bool IsNmea(std::string_view line) {
  if (!line.starts_with('$') || line.size() < 7) return false;
  const std::string_view type = line.substr(3, 4);
  return type == "GGA," || type == "RMC,";
}

}  // namespace

ContentFit FitGnss(const TextSample& sample) {
  ContentFit none;
  none.content.kind = FileKind::kGnss;
  const std::optional<TimeColumn> time = FindTime(sample, kGnssSteps);
  none.failed = "no time that increases in steps of 0.04 s to 2 minutes";
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  if (!time) return none;
  none.failed = "the header names angular rates and accelerations";
  if (NamesInertialData(meanings)) return none;
  if (const std::optional<GnssChoice> choice = NamedGnssChoice(sample))
    return FitGnssChoice(sample, *time, *choice);
  if (FindColumn(meanings, "lat") && FindColumn(meanings, "lon")) {
    none.score = 0.75;
    none.failed = "no column is a height above the ellipsoid (one above the sea is not)";
    return none;
  }
  const GnssChoice choice = GnssChoiceByCount(sample, *time);
  constexpr double kOtherNames = 0.5;  // the time is there, and little else
  none.score = kOtherNames;
  none.failed = "the header names no latitude and longitude";
  if (!MayBePosition(meanings, choice.position)) return none;
  return FitGnssChoice(sample, *time, choice);
}

std::optional<GnssFormat> FindGnssFormat(std::string_view beginning) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (beginning.starts_with(kByteOrderMark)) beginning.remove_prefix(kByteOrderMark.size());
  while (!beginning.empty()) {
    const std::size_t end = std::min(beginning.find('\n'), beginning.size());
    const std::string_view line = beginning.substr(0, end);
    if (IsNmea(line)) return GnssFormat::kNmea;
    if (IsRtklibHeader(line) || IsRtklibRow(line)) return GnssFormat::kRtklib;
    beginning.remove_prefix(std::min(end + 1, beginning.size()));
  }
  return std::nullopt;
}

}  // namespace dn::files_internal
