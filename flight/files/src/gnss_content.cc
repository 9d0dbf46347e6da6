#include "gnss_content.h"

#include <dn/geo/text_fields.h>
#include <dn/gnss/changed_positions.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "calendar_text.h"
#include "gnss_columns.h"
#include "gnss_meaning.h"
#include "gnss_path.h"
#include "picked_columns.h"
#include "trajectory_content.h"
#include "trajectory_fit.h"

namespace dn::files_internal {
namespace {

// GNSS receivers have at most this rate, inertial sensors a higher one.
constexpr double kMostGnssHz = 25.0;
constexpr std::size_t kFewestChanged = 5;
constexpr StepRange kGnssSteps{1.0 / kMostGnssHz - 1e-3, 120.0, 0.5};

/// Returns whether the rows are those of a documented format, without names of columns.
bool IsPlainGnss(const TextSample& sample, const TimeColumn& time, const GnssChoice& choice) {
  if (sample.needs_names || time.week || time.at != 0 || time.name != "t") return false;
  if (!choice.added.empty() || !choice.crs.empty()) return false;
  const std::vector<NamedColumn> all = choice.Quantities();
  std::size_t at = 1;
  for (const NamedColumn& column : all) {
    if (column.at != at++) return false;
  }
  const bool named = choice.position[0].name == "lat" && choice.position[2].name == "h" &&
                     (choice.sigma.empty() || choice.sigma[0].name == "sigma_e");
  return named && sample.table.columns == at;
}

/// Returns whether the columns are those of ob_gins, which has the velocity before the sigmas.
bool IsPlainObGins(const TextSample& sample, const TimeColumn& time, const GnssChoice& choice) {
  const bool ordered = choice.velocity.size() == 6 && choice.velocity[0].name == "vn" &&
                       choice.velocity[0].at == 4 && !choice.by_name;
  return ordered && !sample.needs_names && !time.week && time.at == 0 && time.name == "t" &&
         choice.position[0].name == "lat";
}

bool IsSigmaTriple(const double* values) {
  constexpr double kMostSigmaM = 1000.0;
  const bool zero = values[0] == 0.0 && values[1] == 0.0 && values[2] == 0.0;
  return zero ||
         std::all_of(values, values + 3, [](double x) { return x > 0.0 && x < kMostSigmaM; });
}

/// Returns whether three columns of every row are sigmas, or unknown (0).
bool AreSigmaRows(const TextTable& table, std::size_t at) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!IsSigmaTriple(table.row(i) + at)) return false;
  }
  return true;
}

bool AreAllZero(const TextTable& table, std::size_t at) {
  return LargestValue(table, at) == 0.0 && LargestValue(table, at + 1) == 0.0 &&
         LargestValue(table, at + 2) == 0.0;
}

/// Returns the columns of a trajectory with the same positions; empty without attitudes.
ColumnNames AttitudeColumns(const TextSample& sample, const TimeColumn& time,
                            const GnssChoice& choice) {
  std::vector<NamedColumn> all = FindAngles(sample);
  if (all.empty() || !choice.crs.empty()) return {};
  all.insert(all.end(), choice.position.begin(), choice.position.end());
  all.insert(all.end(), choice.added.begin(), choice.added.end());
  return FormatNames(time, all);
}

void DescribeGnss(const TextSample& sample, const TimeColumn& time, const GnssChoice& choice,
                  const TextTable& table, FileContent* content) {
  content->has_sigma = !choice.sigma.empty() && !AreAllZero(table, 4);
  content->has_velocity = !choice.velocity.empty() && !AreAllZero(table, table.columns - 3);
  content->accuracy = choice.accuracy;
  content->crs = choice.crs;
  content->attitude = AttitudeColumns(sample, time, choice);
  if (IsPlainObGins(sample, time, choice)) {
    content->gnss_format = GnssFormat::kObGins;
    return;
  }
  if (IsPlainGnss(sample, time, choice)) return;
  std::vector<NamedColumn> all = choice.Quantities();
  all.insert(all.end(), choice.added.begin(), choice.added.end());
  content->columns = FormatNames(time, all);
}

/// Returns the rows with a new position.
TextTable ChangedPositions(const TextTable& table) {
  TextTable changed;
  changed.columns = table.columns;
  const double* before = nullptr;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* row = table.row(i);
    if (ComparePosition(row + 1, before) != RowPosition::kNew) continue;
    before = row + 1;
    changed.values.insert(changed.values.end(), row, row + table.columns);
    changed.lines.push_back(table.lines[i]);
  }
  return changed;
}

bool IsEcef(const TextTable& table) { return FindCoordinateSystem(table) == "ecef"; }

/// Returns whether the header, if there is one, lets the columns be a position: it names one of
/// them so, and none as another quantity.
bool MayBePosition(const TextSample& sample, const std::vector<NamedColumn>& position) {
  if (sample.names.empty()) return true;
  const std::vector<ColumnMeaning> plain = FindMeanings(sample),
                                   spelled = FindGnssMeanings(WithSpelledNames(sample));
  const auto names_it = [](const std::vector<ColumnMeaning>& meanings, std::size_t at) {
    constexpr std::array<std::string_view, 4> kNames{"lat", "lon", "h", "h_msl"};
    return at < meanings.size() && std::ranges::find(kNames, meanings[at].name) != kNames.end();
  };
  const auto is_position = [&](const NamedColumn& column) {
    return names_it(plain, column.at) || names_it(spelled, column.at);
  };
  return std::ranges::any_of(position, is_position) &&
         std::ranges::all_of(position, [&](const NamedColumn& column) {
           return is_position(column) || IsUnnamed(plain, column.at);
         });
}

/// Returns whether latitude and longitude have the same values in all of several rows.
bool StandsStill(const TextTable& table) {
  for (std::size_t i = 1; i < table.rows(); ++i) {
    if (table.row(i)[1] != table.row(0)[1] || table.row(i)[2] != table.row(0)[2]) return false;
  }
  return table.rows() > 1;
}

/// Returns whether two columns cannot be latitude and longitude: they have whole numbers.
bool AreWholeNumbers(const GnssChoice& choice, const TextTable& table) {
  return !choice.by_name && AreIntegers(table, 1) && AreIntegers(table, 2);
}

ContentFit FitGnssChoice(const TextSample& sample, const TimeColumn& time, GnssChoice choice) {
  FileContent content;
  content.kind = FileKind::kGnss;
  FitTests tests(5.0);
  const bool named = choice.by_name || MayBePosition(sample, choice.position);
  if (!tests.Expect(named, "the header names no latitude and longitude")) {
    return tests.Result(content);
  }
  const TextTable table = GnssRows(sample, time, choice.Quantities());
  if (!tests.Expect(AreNumbers(table, sample), TextReason(sample, choice.position))) {
    return tests.Result(content);
  }
  content.time_offset_s = FindTimeOffset(table.row(0)[0]);
  const bool path = choice.crs == "ecef" ? IsEcef(table)
                                         : AreCoordinates(table) && !AreWholeNumbers(choice, table);
  tests.Expect(path, "no latitude, longitude and height with a speed below 1000 m/s");
  // Columns of a documented format may be at rest. Other constant columns may be anything.
  tests.Expect(choice.by_name || sample.names.empty() || !StandsStill(table),
               "the columns after the time are constant, and no header names them as a position");
  const std::size_t velocity = table.columns - 3;
  const bool sigmas = (choice.sigma.empty() || AreSigmaRows(table, 4)) &&
                      (choice.velocity.empty() || AreSigmaRows(table, velocity));
  tests.Expect(sigmas, "the columns of the sigmas are not sigmas");
  if (choice.position[0].name == "lat" && choice.added.empty() && IsLongitudeFirst(table)) {
    std::swap(choice.position[0].name, choice.position[1].name);
    content.why = "the longitude comes before the latitude";
  }
  content.why += (content.why.empty() || choice.note.empty() ? "" : "; ") + choice.note;
  DescribeGnss(sample, time, choice, table, &content);
  ContentFit fit = tests.Result(std::move(content));
  const bool unknown_rest = !choice.by_name && choice.sigma.empty() && choice.velocity.empty() &&
                            sample.table.columns > choice.position.back().at + 1;
  if (unknown_rest) fit.score *= 0.6;
  // Other kinds come before a position whose place is not the documented one.
  const bool elsewhere =
      !choice.by_name && choice.position[0].at != std::max(time.at, time.week.value_or(0)) + 1;
  if (elsewhere) fit.score *= 0.8;
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
  // A logger may write the time of arrival before the sentence.
  const std::size_t begin = line.find('$');
  if (begin == line.npos || line.size() < begin + 7) return false;
  if (begin > 0 && line.find('*', begin) == line.npos) return false;
  const std::string_view type = line.substr(begin + 3, 4);
  return type == "GGA," || type == "RMC,";
}

}  // namespace

ContentFit FitGnss(const TextSample& sample) {
  ContentFit none;
  none.content.kind = FileKind::kGnss;
  const TextSample spelled = WithSpelledNames(sample);
  const std::optional<TimeColumn> time = FindTime(spelled, kGnssSteps);
  none.failed = TimeReason(spelled, "in steps of 0.04 s to 2 minutes");
  if (!time) return none;
  none.failed = "the header names angular rates and accelerations";
  if (NamesInertialData(FindMeanings(sample))) return none;
  FoundGnss found = FindGnssColumns(sample, spelled, *time);
  if (!found.failed.empty()) {
    none.score = 0.75;
    none.failed = found.failed;
    return none;
  }
  return FitGnssChoice(sample, *time, std::move(found.choice));
}

std::optional<FileContent> FindGnssBesideImu(const TextSample& sample, const TimeColumn& time) {
  FoundGnss found = FindGnssColumns(sample, WithSpelledNames(sample), time);
  if (!found.failed.empty() || !found.choice.by_name || !found.choice.crs.empty()) {
    return std::nullopt;
  }
  const TextTable table = ChangedPositions(GnssRows(sample, time, found.choice.Quantities()));
  const bool rare = MedianTimeStep(table) >= kGnssSteps.least_s;  // not the output of a filter
  if (table.rows() < kFewestChanged || !rare || !AreCoordinates(table)) return std::nullopt;
  FileContent content;
  content.kind = FileKind::kGnss;
  content.why = found.choice.note + (found.choice.note.empty() ? "" : "; ") +
                "make sure that the positions are those of the receiver, not of a filter";
  content.time_offset_s = FindTimeOffset(table.row(0)[0]);
  DescribeGnss(sample, time, found.choice, table, &content);
  content.only_changed = true;
  return content;
}

bool NamesPosition(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample),
                                   spelled = FindGnssMeanings(WithSpelledNames(sample));
  const bool inertial = FindColumn(meanings, "wx") && FindColumn(meanings, "fx");
  return !inertial && FindColumn(spelled, "lat") && FindColumn(spelled, "lon");
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
