#include "trajectory_hints.h"

#include <dn/error.h>
#include <dn/geo/gps_time.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>
#include <dn/navigation/attitude_agreement.h>
#include <dn/navigation/track_agreement.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace dn::apps {
namespace {

using Eigen::Vector3d;

// Difference of two mean cosines that decides which reading follows the course.
constexpr double kClearCourse = 0.5;
// Correlation of the turns of GNSS and gyros that shows the handedness of the positions.
constexpr double kClearTurns = 0.7;
// Two clocks that agree within this are one.
constexpr double kSameClockS = 0.5;
constexpr double kWholeSecondS = 0.1;
// Leap seconds between GPS time and UTC since 2006.
constexpr double kLeastLeapS = 14.0, kMostLeapS = 18.0;

enum class Culprit { kTrajectory, kGnss, kEither };

std::string TrajectoryName(const Flight& flight) {
  return "the trajectory " + flight.config.trajectory->file;
}

std::string GnssName(const Flight& flight) {
  return "the GNSS positions of " + flight.config.gnss->file;
}

/// Returns the columns of the trajectory, or none if it is binary.
ColumnNames TextColumnsNow(const FlightConfig& config) {
  const std::filesystem::path file = config.folder / config.trajectory->file;
  if (IsBinaryFile(file)) return {};
  const TrajectoryColumns& columns = config.trajectory->columns;
  if (!columns.names.empty()) return columns.names;
  ColumnNames names{"t"};
  for (const std::string& name : TrajectoryQuantities(columns.has_quaternion())) {
    if (name != "t") names.push_back(name);
  }
  return names;
}

/// Returns the hint with the corrected columns; a binary file has to be corrected itself.
DataHint WithColumns(const std::string& finding, const ColumnNames& columns,
                     const std::string& correction) {
  if (columns.empty()) return {finding + ": " + correction, "", ""};
  return {finding, "trajectory.columns", FormatColumnNames(columns)};
}

/// Replaces names, which are whole quantities with or without a sign and a suffix.
ColumnNames Renamed(ColumnNames names, const std::vector<std::pair<std::string, std::string>>& to) {
  for (std::string& name : names) {
    const std::size_t sign = name.starts_with('-') ? 1 : 0;
    for (const auto& [from, by] : to) {
      if (name.compare(sign, from.size(), from) != 0) continue;
      const char next = sign + from.size() < name.size() ? name[sign + from.size()] : '_';
      if (next != '_') continue;
      name.replace(sign, from.size(), by);
      break;
    }
    if (name.starts_with("--")) name.erase(0, 2);
  }
  return names;
}

Culprit WhoIsExchanged(const Flight& flight, const DataAgreement& agreement,
                       const TrackComparison& found) {
  if (agreement.turns && std::abs(agreement.turns->correlation) > kClearTurns) {
    return agreement.turns->correlation > 0.0 ? Culprit::kTrajectory : Culprit::kGnss;
  }
  if (IsBinaryFile(flight.config.folder / flight.config.trajectory->file) ||
      flight.config.trajectory->columns.attitude == TrajectoryColumns::Attitude::kQuaternionNed ||
      flight.config.trajectory->columns.attitude ==
          TrajectoryColumns::Attitude::kRollPitchHeading) {
    if (found.course_as_read - found.course_exchanged > kClearCourse) return Culprit::kGnss;
    if (found.course_exchanged - found.course_as_read > kClearCourse) return Culprit::kTrajectory;
  }
  return Culprit::kEither;  // an attitude from east fits the course of exchanged coordinates
}

DataHint ExchangedHint(const Flight& flight, Culprit culprit) {
  if (culprit == Culprit::kGnss) {
    return {GnssName(flight) +
                " fit the trajectory with latitude and longitude exchanged: put "
                "latitude first in gnss.file, or name its columns in gnss.columns",
            "", ""};
  }
  const std::string finding =
      TrajectoryName(flight) + " fits the GNSS positions with latitude and longitude exchanged";
  if (culprit == Culprit::kEither) {
    return {finding + " in one of the two files: correct that one (latitude comes first)", "", ""};
  }
  return WithColumns(finding,
                     Renamed(TextColumnsNow(flight.config), {{"lat", "lon"}, {"lon", "lat"}}),
                     "exchange them in the file");
}

DataHint RadiansHint(const Flight& flight, bool trajectory) {
  if (!trajectory) {
    return {
        "latitude and longitude of gnss.file look like radians (so read, they fit the "
        "trajectory): multiply them by 57.29577951308232",
        "", ""};
  }
  return WithColumns(
      TrajectoryName(flight) + " fits the GNSS positions if its latitude and longitude are radians",
      Renamed(TextColumnsNow(flight.config), {{"lat", "lat_rad"}, {"lon", "lon_rad"}}),
      "convert them to degrees");
}

DataHint PlaceHint(const Flight& flight, const DataAgreement& agreement,
                   const TrackComparison& found) {
  switch (found.place) {
    case PlaceMistake::kNone:
    case PlaceMistake::kElsewhere:
      break;
    case PlaceMistake::kExchanged:
      return ExchangedHint(flight, WhoIsExchanged(flight, agreement, found));
    case PlaceMistake::kTrajectoryRadians:
    case PlaceMistake::kGnssRadians:
      return RadiansHint(flight, found.place == PlaceMistake::kTrajectoryRadians);
  }
  return {fmt::format("{} lies {:.1f} km from {}: one of them is of another place, or its "
                      "coordinate system is not the declared one (trajectory.crs, gnss.crs)",
                      TrajectoryName(flight), found.distance_m / 1e3, GnssName(flight)),
          "", ""};
}

/// Rounds a difference of two clocks to what the comparison determines.
double RoundedShift(double shift_s) {
  const double whole_s = std::round(shift_s);
  if (std::abs(shift_s - whole_s) < kWholeSecondS && std::abs(whole_s) > 1.0) return whole_s;
  return std::round(100.0 * shift_s) / 100.0;
}

/// Returns a remedy after its cause: what a clock that is early by some seconds may be in.
std::string CauseAndRemedy(double early_s, std::string remedy) {
  const auto asked = [&](const std::string& question) {
    remedy[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(remedy[0])));
    return question + "? " + remedy;
  };
  if (early_s >= kLeastLeapS && early_s <= kMostLeapS && early_s == std::round(early_s)) {
    return asked(fmt::format(": are they in UTC, which is {:.0f} s behind GPS time", early_s));
  }
  if (std::abs(early_s) >= kDayS - kMostLeapS) {
    return asked(fmt::format(" ({:.4g} days): do they count from another day or week",
                             std::abs(early_s) / kDayS));
  }
  return ": " + remedy;
}

std::string EarlyOrLate(double early_s) {
  return fmt::format("{:.10g} s {}", std::abs(early_s), early_s > 0.0 ? "early" : "late");
}

std::string AddToTimes(double early_s) {
  return fmt::format("{} {:.10g} s {} the times of the trajectory",
                     early_s > 0.0 ? "add" : "subtract", std::abs(early_s),
                     early_s > 0.0 ? "to" : "from");
}

/// Adds a hint if the clock of the trajectory is wrong by the GNSS positions. If the inertial data
/// show that the clock of GNSS is, another hint says so.
void HintTrajectoryClock(const Flight& flight, const DataAgreement& agreement,
                         const TrackComparison& found, std::vector<DataHint>* hints) {
  if (found.shift_s == 0.0) return;
  const bool gnss_off = agreement.lag && agreement.lag->certain;
  const double error_s = found.shift_s + (gnss_off ? agreement.lag->lag_s : 0.0);
  if (gnss_off && std::abs(error_s) < kSameClockS) return;
  const double early_s = RoundedShift(-error_s);
  const std::string text =
      fmt::format("the motion of {} fits {} if its time tags are {}", TrajectoryName(flight),
                  gnss_off ? "the inertial data" : "the GNSS positions", EarlyOrLate(early_s));
  if (gnss_off || (flight.imu && GnssTagsFit(flight))) {
    hints->push_back({text + CauseAndRemedy(early_s, AddToTimes(early_s)), "", ""});
    return;
  }
  const double offset_s = flight.config.gnss->time_offset_s + early_s;
  const std::string gnss =
      "; or the GNSS tags are " + EarlyOrLate(-early_s) +
      CauseAndRemedy(-early_s, "set gnss.time_offset_s: " + FormatDouble(offset_s));
  hints->push_back({text + CauseAndRemedy(early_s, AddToTimes(early_s)) + gnss, "", ""});
}

void HintHeights(const Flight& flight, const TrackComparison& found, std::vector<DataHint>* hints) {
  const double up_m = found.apart_enu_m.z();
  switch (found.height) {
    case HeightMistake::kNone:
      return;
    case HeightMistake::kTrajectoryFeet:
      hints->push_back({"the heights of " + TrajectoryName(flight) +
                            " are those of the GNSS positions in feet: multiply them by 0.3048",
                        "", ""});
      return;
    case HeightMistake::kGnssFeet:
      hints->push_back({"the heights of " + GnssName(flight) +
                            " are those of the trajectory in feet: multiply them by 0.3048",
                        "", ""});
      return;
    case HeightMistake::kConstant:
      hints->push_back(
          {fmt::format("{} lies {:.1f} m {} {}: are heights of one above the sea (a geoid) or in "
                       "another datum? Both must be above the ellipsoid of WGS84: add {:.1f} m to "
                       "the lower ones",
                       TrajectoryName(flight), std::abs(up_m), up_m < 0.0 ? "below" : "above",
                       GnssName(flight), std::abs(up_m)),
           "", ""});
  }
}

void HintDatum(const Flight& flight, const TrackComparison& found, std::vector<DataHint>* hints) {
  const Vector3d& apart_m = found.apart_enu_m;
  if (apart_m.head<2>().norm() <= found.tolerance_m) return;
  hints->push_back(
      {fmt::format("{} lies {:.1f} m {} and {:.1f} m {} of {} throughout: are they in the same "
                   "datum, and is gnss.lever_arm_m declared?",
                   TrajectoryName(flight), std::abs(apart_m.y()),
                   apart_m.y() < 0.0 ? "south" : "north", std::abs(apart_m.x()),
                   apart_m.x() < 0.0 ? "west" : "east", GnssName(flight)),
       "", ""});
}

void HintTrack(const Flight& flight, const DataAgreement& agreement, const TrackComparison& found,
               std::vector<DataHint>* hints) {
  if (found.place != PlaceMistake::kNone) hints->push_back(PlaceHint(flight, agreement, found));
  if (found.place == PlaceMistake::kElsewhere) return;
  if (!found.one_motion) {
    if (found.tolerance_m > 0.0) {
      hints->push_back({TrajectoryName(flight) + " shows another motion than " + GnssName(flight) +
                            " at every offset of its time tags: are they of one flight?",
                        "", ""});
    }
    return;
  }
  HintTrajectoryClock(flight, agreement, found, hints);
  HintDatum(flight, found, hints);
  HintHeights(flight, found, hints);
}

/// Returns the columns of quaternions that belong to other body axes, for a half turn about an
/// axis; none for other turns.
ColumnNames TurnedQuaternion(const ColumnNames& names, const Eigen::Matrix3d& R_turn) {
  for (int k = 0; k < 3; ++k) {
    if (R_turn.diagonal().sum() != -1.0 || R_turn(k, k) != 1.0) continue;
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    const auto component = [](int i) { return std::string("q") + "xyz"[i]; };
    return Renamed(names, {{"qw", component(k)},
                           {component(k), "-qw"},
                           {component(next), "-" + component(last)},
                           {component(last), component(next)}});
  }
  return {};
}

void HintAttitudeMistake(const Flight& flight, const AttitudeMistake& mistake,
                         std::vector<DataHint>* hints) {
  using Kind = AttitudeMistake::Kind;
  const ColumnNames columns = TextColumnsNow(flight.config);
  const bool angles = HasColumn(columns, "roll");
  const std::string finding =
      "the turns of " + TrajectoryName(flight) + " fit those of the gyros with ";
  const auto add = [&](const std::string& what, const ColumnNames& corrected) {
    hints->push_back(WithColumns(finding + what, corrected, "correct the attitudes in the file"));
  };
  const auto renamed = [&](const std::vector<std::pair<std::string, std::string>>& to) {
    return angles ? Renamed(columns, to) : ColumnNames{};
  };
  switch (mistake.kind) {
    case Kind::kRollSign:
      return add("the opposite sign of roll", renamed({{"roll", "-roll"}}));
    case Kind::kPitchSign:
      return add("the opposite sign of pitch", renamed({{"pitch", "-pitch"}}));
    case Kind::kHeadingSign:
      return add("the opposite sign of heading",
                 renamed({{"heading", "-heading"}, {"yaw", "-yaw"}}));
    case Kind::kRollPitchExchanged:
      return add("roll and pitch exchanged", renamed({{"roll", "pitch"}, {"pitch", "roll"}}));
    case Kind::kInverse:
      return add("the inverse rotation",
                 angles || columns.empty()
                     ? ColumnNames{}
                     : Renamed(columns, {{"qx", "-qx"}, {"qy", "-qy"}, {"qz", "-qz"}}));
    case Kind::kAxes:
      break;
  }
  add(fmt::format("body axes {} (x y z; F forward, B back, R right, L left, D down, U up)",
                  AxesName(mistake.R_turn.transpose())),
      angles || columns.empty() ? ColumnNames{} : TurnedQuaternion(columns, mistake.R_turn));
}

}  // namespace

std::vector<DataHint> TrajectoryHints(const Flight& flight, const DataAgreement& agreement) {
  std::vector<DataHint> hints;
  if (!flight.trajectory || !flight.config.trajectory) return hints;
  const std::optional<TrackComparison> found = CompareTracks(flight);
  if (found) HintTrack(flight, agreement, *found, &hints);
  if (found && (found->place != PlaceMistake::kNone || !found->one_motion)) return hints;
  const double lag_s = agreement.lag && agreement.lag->certain ? agreement.lag->lag_s : 0.0;
  const auto mistake = FindAttitudeMistake(flight, found ? found->shift_s + lag_s : 0.0);
  if (mistake) HintAttitudeMistake(flight, *mistake, &hints);
  return hints;
}

std::vector<DataHint> TrajectoryHints(const FlightConfig& config) {
  try {
    const Flight flight =
        ReadFlight(config, {.imu = true, .gnss = true, .trajectory = true, .optional = true});
    const std::optional<TrackComparison> tracks = CompareTracks(flight);
    // Only tracks that differ need the inertial data to say which one is wrong.
    const bool differ = tracks && !tracks->Agrees();
    return TrajectoryHints(flight, differ ? FindDataAgreement(flight) : DataAgreement{});
  } catch (const InvalidInput&) {  // the command reports what it cannot read
    return {};
  }
}

}  // namespace dn::apps
