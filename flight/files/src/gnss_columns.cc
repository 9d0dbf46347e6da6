#include "gnss_columns.h"

#include <dn/geo/local_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gnss_meaning.h"
#include "gnss_path.h"
#include "lower_case.h"
#include "trajectory_content.h"

namespace dn::files_internal {
namespace {

using NamedList = std::vector<NamedColumn>;
using Meanings = std::vector<ColumnMeaning>;
using TripleNames = std::array<const char*, 3>;

constexpr TripleNames kSigma{"sigma_e", "sigma_n", "sigma_u"};
constexpr TripleNames kVelocity{"ve", "vn", "vu"};
constexpr TripleNames kVelocitySigma{"sigma_ve", "sigma_vn", "sigma_vu"};
constexpr TripleNames kNedVelocity{"vn", "ve", "vd"};
constexpr TripleNames kNedSigma{"sigma_n", "sigma_e", "sigma_d"};
constexpr TripleNames kNedVelocitySigma{"sigma_vn", "sigma_ve", "sigma_vd"};
constexpr double kMostSigma = 1000.0;
constexpr double kMostMetresOfHeight = 2e4;

void Append(const NamedList& columns, NamedList* to) {
  to->insert(to->end(), columns.begin(), columns.end());
}

void AddNote(const std::string& text, std::string* note) {
  *note += (note->empty() ? "" : "; ") + text;
}

/// Returns the ending of a name for a unit of length; empty for metres.
std::string LengthEnding(const std::string& unit) {
  for (const char* each : {"mm", "cm"}) {
    if (unit == each) return "_" + unit;
  }
  if (unit == "ft" || unit == "feet" || unit == "foot") return "_ft";
  return unit == "usft" || unit == "us-ft" || unit == "ftus" ? "_usft" : "";
}

std::string WithUnit(const std::string& name, const Meanings& meanings, std::size_t at) {
  return name.starts_with("var_") ? name : name + LengthEnding(meanings[at].unit);
}

std::optional<NamedColumn> FindOneName(const Meanings& meanings,
                                       std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (auto column = FindColumn(meanings, name)) return column;
  }
  return std::nullopt;
}

/// Returns the columns with these names; down may stand for up.
std::optional<NamedList> FindTriple(const Meanings& meanings, const TripleNames& names) {
  NamedList columns;
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

/// Returns the height, one above the ellipsoid rather than one that does not say what it is.
std::optional<NamedColumn> FindHeight(const TextSample& spelled, const Meanings& meanings) {
  for (std::size_t i = 0; i < meanings.size(); ++i) {
    const std::string name = LowerCase(spelled.names[i]);
    const bool ellipsoidal = name.find("ell") != name.npos || name.find("hae") != name.npos;
    if (meanings[i].name == "h" && ellipsoidal) return NamedColumn{"h", i};
  }
  return FindColumn(meanings, "h");
}

/// Altitudes are above the ellipsoid in some programs, above the sea or the ground in others.
std::string AltitudeNote(const std::string& name) {
  const std::string lower = LowerCase(name);
  const auto has = [&](const char* part) { return lower.find(part) != lower.npos; };
  const bool altitude = (has("alt") || has("ele")) && !has("ell") && !has("hae");
  return altitude ? "make sure that '" + name + "' is above the ellipsoid" : std::string();
}

/// Returns whether all values can be degrees and minutes (dddmm.mmmm), and are not plain degrees.
bool AreDegreesMinutes(const TextTable& table) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    for (const std::size_t k : {1, 2}) {
      const double value = std::abs(table.row(i)[k]);
      if (value > 18000.0 || std::fmod(value, 100.0) >= 60.0) return false;
    }
  }
  return std::max(LargestValue(table, 1), LargestValue(table, 2)) > 360.0;
}

/// Returns the ending of the names of latitude and longitude for their unit: by the names, else by
/// the size of the values.
std::string AngleEnding(const std::string& unit, const TextTable& raw, std::string* note) {
  constexpr double kLeastInteger = 1e6;
  if (unit.starts_with("rad")) return "_rad";
  if (unit.find("e7") != unit.npos || unit.find("e-7") != unit.npos) return "_1e7";
  if (unit.find("mm") != unit.npos) return "_ddmm";
  if (raw.rows() == 0) return {};
  const bool large = std::max(LargestValue(raw, 1), LargestValue(raw, 2)) > kLeastInteger;
  if (large && AreIntegers(raw, 1) && AreIntegers(raw, 2)) {
    AddNote("latitude and longitude are in 1e-7 deg", note);
    return "_1e7";
  }
  if (!AreDegreesMinutes(raw)) return {};
  AddNote("latitude and longitude are degrees and minutes, dddmm.mmmm", note);
  return "_ddmm";
}

/// Returns why the unit of the heights is unknown; sets the ending of their name.
std::string HeightProblem(const TextTable& raw, bool integer_angles, const std::string& column,
                          std::string* name, std::string* note) {
  if (raw.rows() == 0 || *name != "h") return {};
  const bool too_large = LargestValue(raw, 3) > kMostMetresOfHeight;
  if (integer_angles && too_large && AreIntegers(raw, 3)) {
    AddNote("'" + column + "' is in mm", note);
    *name = "h_mm";
    return {};
  }
  const bool unsure = integer_angles && AreIntegers(raw, 3);
  if (!too_large && !unsure) return {};
  return "the heights in '" + column + "' " +
         (too_large ? "are too large for metres" : "may be in m, cm or mm") +
         ": state the unit in the name, as in '" + column +
         " (mm)', or as h, h_cm, h_mm or h_ft in gnss.columns";
}

void FindSigmas(const TextSample& sample, const Meanings& meanings, GnssChoice* choice) {
  const auto east = FindOneName(meanings, {"sigma_e", "var_e", "sigma_en"}),
             north = FindOneName(meanings, {"sigma_n", "var_n", "sigma_en"}),
             up = FindOneName(meanings, {"sigma_u", "sigma_d", "var_u"});
  if (east && north && up) {
    for (const NamedColumn& each : {*east, *north, *up}) {
      choice->sigma.push_back({WithUnit(each.name, meanings, each.at), each.at});
    }
    if (east->at == north->at) {
      AddNote("'" + sample.names[east->at] + "' is taken as the sigma of east and of north",
              &choice->note);
    }
    return;
  }
  for (const auto& each : {east, north, up, FindColumn(meanings, "accuracy")}) {
    const bool known = each && choice->accuracy.find(sample.names[each->at]) != std::string::npos;
    if (!each || known) continue;
    choice->accuracy += (choice->accuracy.empty() ? "'" : ", '") + sample.names[each->at] + "'";
  }
}

/// Returns whether the three sigmas of all rows are positive, or unknown (0).
bool ArePositiveOrZero(const TextTable& table) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* s = table.row(i) + 1;
    const bool zero = s[0] == 0.0 && s[1] == 0.0 && s[2] == 0.0;
    if (!zero && !(s[0] > 0.0 && s[1] > 0.0 && s[2] > 0.0)) return false;
  }
  return true;
}

/// Leaves out accuracies of other kinds that are not known in all rows, as with -1 for unknown.
void LeaveOutUnknownAccuracies(const TextSample& sample, const TimeColumn& time,
                               GnssChoice* choice) {
  if (choice->sigma.empty()) return;
  const std::string& name = choice->sigma[0].name;
  if (!name.starts_with("sigma_en") && !name.starts_with("var_")) return;
  const TextTable table = GnssRows(sample, time, choice->sigma);
  if (AreNumbers(table, sample) && ArePositiveOrZero(table)) return;
  choice->accuracy = "'" + sample.names[choice->sigma[0].at] + "'";
  AddNote(choice->accuracy + " is not used: it is not positive in all rows", &choice->note);
  choice->sigma.clear();
}

bool IsMetresPerSecond(const std::string& unit) {
  return unit.empty() || unit == "m/s" || unit == "mps" || unit == "m/sec" || unit == "ms-1";
}

void FindVelocities(const TextSample& sample, const Meanings& meanings, GnssChoice* choice) {
  const auto velocity = FindTriple(meanings, kVelocity),
             sigma = FindTriple(meanings, kVelocitySigma);
  if (!velocity || !sigma) return;
  NamedList all = *velocity;
  Append(*sigma, &all);
  for (const NamedColumn& each : all) {
    if (IsMetresPerSecond(meanings[each.at].unit)) continue;
    AddNote("the velocities are not used, since '" + sample.names[each.at] + "' is not in m/s",
            &choice->note);
    return;
  }
  choice->velocity = all;
}

/// Says which column of latitude, longitude and height is missing.
std::string NoHeight(const TextSample& sample, const Meanings& meanings) {
  const auto sea = FindColumn(meanings, "h_msl");
  if (!sea) return "no column is a height above the ellipsoid (one above the sea is not)";
  return "'" + sample.names[sea->at] +
         "' is above the sea, and no column is a height above the ellipsoid or the undulation of "
         "the geoid: export one of them";
}

/// Sets the columns of latitude, longitude and height. Returns what is wrong with them.
std::string FindGeographic(const TextSample& sample, const TextSample& spelled,
                           const Meanings& meanings, const TimeColumn& time, GnssChoice* choice) {
  const auto lat = FindColumn(meanings, "lat"), lon = FindColumn(meanings, "lon"),
             undulation = FindColumn(meanings, "undulation");
  auto height = FindHeight(spelled, meanings);
  const bool above_sea = !height && undulation && FindColumn(meanings, "h_msl");
  if (above_sea) {
    height = NamedColumn{"h", FindColumn(meanings, "h_msl")->at};
    choice->added.push_back(*undulation);
  }
  if (!height) return NoHeight(sample, meanings);
  Append(FindMinutes(meanings), &choice->added);
  for (const char* hemisphere : {"lat_ns", "lon_ew"}) {
    if (const auto column = FindColumn(meanings, hemisphere)) choice->added.push_back(*column);
  }
  if (!above_sea) choice->note = AltitudeNote(sample.names[height->at]);
  height->name = WithUnit("h", meanings, height->at);
  choice->position = {*lat, *lon, *height};
  const TextTable raw = PickRows(sample, time, choice->position);
  const std::string ending = AngleEnding(meanings[lat->at].unit, raw, &choice->note);
  for (const std::size_t k : {0, 1}) choice->position[k].name += ending;
  return HeightProblem(raw, ending == "_1e7", sample.names[height->at], &choice->position[2].name,
                       &choice->note);
}

/// Sets the columns of other coordinates. Returns what is wrong with them, or nullopt if the names
/// have none.
std::optional<std::string> FindOtherCoordinates(const TextSample& sample, const TextSample& spelled,
                                                const Meanings& meanings, const TimeColumn& time,
                                                GnssChoice* choice) {
  auto position = FindTriple(meanings, {"x", "y", "z"});
  const auto east = FindColumn(meanings, "east"), north = FindColumn(meanings, "north");
  auto height = FindHeight(spelled, meanings);
  if (!height) height = FindColumn(meanings, "up");
  if (east && north && height) position = NamedList{*east, *north, *height};
  if (!position) return std::nullopt;
  const bool grid = (*position)[0].name == "east";
  for (NamedColumn& column : *position) column.name = WithUnit(column.name, meanings, column.at);
  choice->position = *position;
  const auto crs = FindCoordinateSystem(GnssRows(sample, time, choice->position));
  if (!grid && crs == "ecef") {
    choice->crs = *crs;
    return "";
  }
  if (!grid) return std::nullopt;
  return "easting and northing need their zone: set gnss.file, gnss.columns: " +
         FormatColumnNames(FormatNames(time, *position)) +
         (crs == "utm:" ? " and gnss.crs, such as utm:32n" : " and gnss.crs: map");
}

FoundGnss FindNamed(const TextSample& sample, const TextSample& spelled, const Meanings& meanings,
                    const TimeColumn& time) {
  FoundGnss found;
  found.choice.by_name = true;
  if (FindColumn(meanings, "lat") && FindColumn(meanings, "lon")) {
    found.failed = FindGeographic(sample, spelled, meanings, time, &found.choice);
  } else if (const auto problem =
                 FindOtherCoordinates(sample, spelled, meanings, time, &found.choice)) {
    found.failed = *problem;
  } else {
    found.choice.position.clear();
    return found;
  }
  FindSigmas(sample, meanings, &found.choice);
  LeaveOutUnknownAccuracies(sample, time, &found.choice);
  FindVelocities(sample, meanings, &found.choice);
  return found;
}

NamedList Triple(const TripleNames& names, std::size_t at) {
  NamedList columns;
  for (const char* name : names) columns.push_back({name, at++});
  return columns;
}

bool IsLetter(const TextSample& sample, std::size_t at, const std::string& letters) {
  if (at >= sample.first_row.size() || sample.first_row[at].size() != 1) return false;
  return letters.find(sample.first_row[at]) != letters.npos;
}

/// Returns the columns of a position from a place on. Letters of hemispheres may follow latitude
/// and longitude. Returns no columns if the row is too short, or if a column has another meaning.
GnssChoice PositionAt(const TextSample& sample, const Meanings& meanings, std::size_t at) {
  GnssChoice choice;
  const bool letters = IsLetter(sample, at + 1, "NSns") && IsLetter(sample, at + 3, "EWew");
  const std::size_t step = letters ? 2 : 1;
  if (at + 2 * step >= sample.table.columns) return choice;
  choice.position = {{"lat", at}, {"lon", at + step}, {"h", at + 2 * step}};
  if (letters) choice.added = {{"lat_ns", at + 1}, {"lon_ew", at + 3}};
  for (const NamedColumn& column : choice.position) {
    const bool other = column.at < meanings.size() && !meanings[column.at].name.empty() &&
                       meanings[column.at].name != column.name;
    if (other) return {};
  }
  return choice;
}

/// Returns the position that the values show. The documented place comes first, positions that
/// stand still come last.
GnssChoice FindPosition(const TextSample& sample, const Meanings& meanings,
                        const TimeColumn& time) {
  constexpr std::size_t kMostPlaces = 32;
  const std::size_t first = std::max(time.at, time.week.value_or(0)) + 1;
  GnssChoice still;
  for (std::size_t at = first; at < std::min(sample.table.columns, first + kMostPlaces); ++at) {
    GnssChoice choice = PositionAt(sample, meanings, at);
    if (choice.position.empty()) continue;
    const TextTable rows = GnssRows(sample, time, choice.position);
    if (!AreNumbers(rows, sample) || !AreCertainCoordinates(rows)) continue;
    if (IsMoving(rows)) return choice;
    if (at == first) still = choice;
  }
  return still.position.empty() ? PositionAt(sample, meanings, first) : still;
}

/// Returns whether three columns are sigmas of east, north and up in all rows: positive and of one
/// size, or unknown (0), and not whole numbers.
bool AreSigmas(const TextTable& table, std::size_t at) {
  constexpr double kMostRatio = 10.0, kLeastUp = 0.3;
  bool whole = true, zero = true;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double *s = table.row(i) + at, least = std::min(s[0], s[1]), most = std::max(s[0], s[1]);
    if (least == 0.0 && most == 0.0 && s[2] == 0.0) continue;
    zero = false;
    if (!(least > 0.0 && most < kMostSigma && s[2] < kMostSigma)) return false;
    if (most > kMostRatio * least || s[2] < kLeastUp * least) return false;
    whole = whole && s[0] == std::floor(s[0]) && s[1] == std::floor(s[1]);
  }
  return zero || !whole;
}

std::string ColumnRange(std::size_t first, std::size_t count) {
  return "columns " + std::to_string(first + 1) + "-" + std::to_string(first + count);
}

/// Sigmas of decimetres and more may be dilutions of precision.
bool AreLarge(const TextTable& table, std::size_t at) {
  constexpr double kLargeM = 0.4;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.row(i)[at] < kLargeM) return false;
  }
  return true;
}

bool HasNegative(const TextTable& table) {
  return std::any_of(table.values.begin(), table.values.end(), [](double x) { return x < 0.0; });
}

/// Takes the columns after the position as those of the documented formats, if their values fit.
void TakeRest(const TextSample& sample, const TimeColumn& time, GnssChoice* choice) {
  const std::size_t at = choice->position.back().at + 1, rest = sample.table.columns - at;
  if (rest != 3 && rest != 6 && rest != 9) return;
  NamedList columns;
  for (std::size_t k = 0; k < rest; ++k) columns.push_back({"skip", at + k});
  const TextTable table = PickRows(sample, time, columns);
  const bool numbers = AreNumbers(table, sample);
  // Three columns with signs are angles of a trajectory, whose positions are not those of GNSS.
  if (rest == 3 && numbers && HasNegative(table)) {
    choice->sigma = Triple(kSigma, at);
    return;
  }
  const bool last = numbers && AreSigmas(table, rest - 2);
  const bool velocity_first = rest == 9 && last && !AreSigmas(table, 1) && AreSigmas(table, 4);
  if (!last || (rest == 9 && !velocity_first && !AreSigmas(table, 1))) {
    AddNote(ColumnRange(at, rest) + " are not used: they are no sigmas of east, north and up",
            &choice->note);
    return;
  }
  if (velocity_first) {
    choice->velocity = Triple(kNedVelocity, at);
    choice->sigma = Triple(kNedSigma, at + 3);
    Append(Triple(kNedVelocitySigma, at + 6), &choice->velocity);
    return;
  }
  if (rest != 6) choice->sigma = Triple(kSigma, at);
  if (rest != 3) choice->velocity = Triple(kVelocity, at + rest - 6);
  if (rest != 3) Append(Triple(kVelocitySigma, at + rest - 3), &choice->velocity);
  if (rest == 3 && AreLarge(table, 1)) {
    AddNote(ColumnRange(at, 3) +
                " are taken for sigmas of east, north and up in m: if they are something else, "
                "such as dilutions of precision, set gnss.columns: " +
                FormatColumnNames(FormatNames(time, choice->position)),
            &choice->note);
  }
}

double Converted(const std::string& name, double value) {
  const auto ends = [&](const char* ending) { return name.ends_with(ending); };
  if (ends("_rad")) return value * kDegPerRad;
  if (ends("_1e7")) return 1e-7 * value;
  if (ends("_mm")) return 1e-3 * value;
  if (ends("_cm")) return 1e-2 * value;
  if (ends("_ft") || ends("_usft")) return 0.3048 * value;
  if (name.starts_with("var_")) return std::sqrt(value);
  if (!ends("_ddmm")) return value;
  const double degrees = std::floor(std::abs(value) / 100.0);
  return std::copysign(degrees + (std::abs(value) - 100.0 * degrees) / 60.0, value);
}

}  // namespace

std::vector<NamedColumn> GnssChoice::Quantities() const {
  NamedList all = position;
  Append(sigma, &all);
  Append(velocity, &all);
  return all;
}

TextTable GnssRows(const TextSample& sample, const TimeColumn& time,
                   const std::vector<NamedColumn>& columns) {
  TextTable table = PickRows(sample, time, columns);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    double* row = table.values.data() + i * table.columns + 1;
    for (std::size_t k = 0; k < columns.size(); ++k) row[k] = Converted(columns[k].name, row[k]);
  }
  return table;
}

FoundGnss FindGnssColumns(const TextSample& sample, const TextSample& spelled,
                          const TimeColumn& time) {
  const Meanings meanings = FindGnssMeanings(spelled);
  FoundGnss found = FindNamed(sample, spelled, meanings, time);
  if (!found.choice.position.empty() || !found.failed.empty()) return found;
  found.choice = FindPosition(sample, meanings, time);
  if (found.choice.position.empty()) {
    found.failed = "no columns are named as latitude, longitude and height";
    return found;
  }
  const std::size_t first = found.choice.position[0].at;
  if (first != std::max(time.at, time.week.value_or(0)) + 1) {
    found.choice.note = "the position is in " + ColumnRange(first, 3) + " by its values";
  }
  TakeRest(sample, time, &found.choice);
  return found;
}

}  // namespace dn::files_internal
