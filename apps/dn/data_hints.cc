#include "data_hints.h"

#include <dn/axis_names.h>
#include <dn/builder/gnss_factors.h>
#include <dn/files/file_content.h>
#include <dn/files/pair_clock.h>
#include <dn/geo/text_table.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trajectory_hints.h"

namespace dn::apps {
namespace {

// Smallest agreement of the directions. It is lower if the body rolls over or is carried around.
constexpr double kMinAgreement = 0.8;
// Instruments are mounted along the axes of their carrier within this angle.
constexpr double kMaxAxesDistanceRad = 35.0 * kRadPerDeg;
// Correlation above which two sensors measure the same turns.
constexpr double kSameTurns = 0.9;
constexpr double kMinGain = 0.1;
// Correlation of mirrored turns. It is lower because east and north have different scales.
constexpr double kMirroredTurns = 0.7;
constexpr double kMinLagS = 1.0;
// Leap seconds between GPS time and UTC since 2006.
constexpr double kLeapSecondsFrom = 14.0, kLeapSecondsTo = 18.0;
// Distance from the origin beyond which LocalFrame loses digits.
constexpr double kFarOriginM = 1e5;
// A longer step between velocities counts as a gap.
constexpr double kLongestStepS = 5.0;

/// Returns the directions without a course that scatters: the body is carried sideways.
BodyDirections Reliable(BodyDirections directions) {
  if (directions.course_agreement < kMinAgreement) directions.course_b.reset();
  return directions;
}

/// Returns the letter of the nearest body axis: F, R, D or, if opposite, B, L, U.
char Letter(const Eigen::Vector3d& direction_b) {
  constexpr char kLetters[2][4] = {"FRD", "BLU"};
  Eigen::Index axis = 0;
  direction_b.cwiseAbs().maxCoeff(&axis);
  return kLetters[direction_b[axis] < 0.0 ? 1 : 0][axis];
}

/// Converts R, which leads to forward-right-down, to the body axes that flight.yaml declares.
Eigen::Matrix3d InDeclaredBody(const FlightConfig& config, Eigen::Matrix3d R) {
  if (config.body_is_flu) R.bottomRows<2>().array() = 0.0 - R.bottomRows<2>().array();
  return R;
}

void HintAxes(const Flight& flight, const BodyDirections& found, std::vector<DataHint>* hints) {
  const AxesFit fit = FitAxes(found);
  const bool reliable = found.down_agreement >= kMinAgreement;
  if (!reliable || fit.distance_rad > kMaxAxesDistanceRad || fit.R_turn.isIdentity()) return;
  const Eigen::Matrix3d R = fit.R_turn * flight.config.imu->read.R_imu_to_body;
  const std::string matrix = MatrixText(InDeclaredBody(flight.config, R));
  std::string text = fmt::format(
      "the inertial data are in axes {} (x y z; F forward, B back, R right, L left, D down, U up), "
      "interpreted as {}",
      AxesName(R), AxesName(flight.config.imu->read.R_imu_to_body));
  text += found.course_b
              ? " by flight.yaml, according to gravity and course"
              : " by flight.yaml, according to gravity (without a usable course, forward "
                "is a guess)";
  hints->push_back({text, "imu.R_imu_to_body", matrix});
}

std::string LagText(double lag_s) {
  return fmt::format("{:.4g} s {}", std::abs(lag_s), lag_s > 0.0 ? "late" : "early");
}

/// `motion`: what shows the lag, for example "the turns of the course fit those of the gyros".
void HintLag(const Flight& flight, const std::string& motion, double lag_s,
             std::vector<DataHint>* hints) {
  const double whole_s = std::round(std::abs(lag_s));
  const bool leap = whole_s >= kLeapSecondsFrom && whole_s <= kLeapSecondsTo &&
                    std::abs(std::abs(lag_s) - whole_s) <= 0.5;
  const char* in_utc = lag_s < 0.0 ? "GNSS" : "inertial";
  std::string text = fmt::format("{} if the GNSS time tags are {}", motion, LagText(lag_s));
  if (!leap) {
    const double offset_s = flight.config.gnss->time_offset_s + lag_s;
    hints->push_back({text + ": the clocks differ", "gnss.time_offset_s", FormatDouble(offset_s)});
    return;
  }
  text +=
      fmt::format(": are the {} tags in UTC, which is {:.0f} s behind GPS time?", in_utc, whole_s);
  const double offset_s =
      (lag_s < 0.0 ? flight.config.gnss->time_offset_s : flight.config.imu->read.time_offset_s) -
      whole_s;
  hints->push_back(
      {text, lag_s < 0.0 ? "gnss.time_offset_s" : "imu.time_offset_s", FormatDouble(offset_s)});
}

/// Adds a hint if the turns or the accelerations show a lag. Accelerations are more exact.
void HintClock(const Flight& flight, const DataAgreement& agreement, std::vector<DataHint>* hints) {
  if (agreement.lag && agreement.lag->certain) {
    const double lag_s = std::round(100.0 * agreement.lag->lag_s) / 100.0;
    HintLag(flight, "the accelerations of the GNSS positions fit the inertial data", lag_s, hints);
    return;
  }
  const auto& turns = agreement.turns;
  const bool shifted = turns && turns->best_correlation > kSameTurns &&
                       turns->best_correlation - turns->correlation > kMinGain &&
                       std::abs(turns->best_lag_s) >= kMinLagS;
  if (shifted) {
    HintLag(flight, "the turns of the course fit those of the gyros", turns->best_lag_s, hints);
  }
}

/// Adds a hint if the course turns opposite to the gyros. Returns whether it does.
bool HintMirror(const DataAgreement& agreement, std::vector<DataHint>* hints) {
  if (!agreement.turns || agreement.turns->correlation >= -kMirroredTurns) return false;
  hints->push_back(
      {"the course turns opposite to the gyros: latitude and longitude may be exchanged in "
       "gnss.file, or in imu.file an axis or all specific forces have the wrong sign (name these "
       "columns -fx, -fy, -fz in imu.columns)",
       "", ""});
  return true;
}

/// Returns true if latitude and longitude could be radians and lie at sea when taken as degrees.
bool LooksLikeRadians(const Geodetic& point) {
  return std::abs(point.lat_rad * kDegPerRad) <= std::numbers::pi / 2.0 &&
         std::abs(point.lon_rad * kDegPerRad) <= std::numbers::pi;
}

/// Returns the root mean square of the horizontal velocities, m/s; 0 without velocities.
double RmsSpeed(const std::vector<MapGnssEpoch>& epochs) {
  double sum = 0.0, n = 0.0;
  for (const MapGnssEpoch& epoch : epochs) {
    if (!epoch.velocity_enu_mps) continue;
    sum += epoch.velocity_enu_mps->head<2>().squaredNorm();
    n += 1.0;
  }
  return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

/// Integrates the velocities between two epochs by trapezoids and returns east and north, m.
/// Returns nullopt if there is a gap between the epochs.
std::optional<Eigen::Vector2d> WayBetween(const std::vector<MapGnssEpoch>& epochs,
                                          std::size_t first, std::size_t last) {
  Eigen::Vector2d way = Eigen::Vector2d::Zero();
  for (std::size_t k = first + 1; k <= last; ++k) {
    const MapGnssEpoch &a = epochs[k - 1], &b = epochs[k];
    const double step_s = b.t_s - a.t_s;
    if (!a.velocity_enu_mps || !b.velocity_enu_mps || step_s > kLongestStepS) return std::nullopt;
    way += 0.5 * step_s * (*a.velocity_enu_mps + *b.velocity_enu_mps).head<2>();
  }
  return way;
}

/// Returns the rms difference between the motion of the positions and the velocities, m/s.
/// exchanged: swaps latitude and longitude first. The legs are so long that the noise of the
/// positions changes the speed by a fifth at most.
double VelocityMisfit(const Flight& flight, double speed_mps, bool exchanged) {
  const std::vector<MapGnssEpoch>& epochs = flight.gnss->epochs;
  const double leg_s = std::max(1.0, 10.0 * TypicalGnssSigma(flight) / speed_mps);
  const auto place = [&](std::size_t k) {
    Geodetic point = flight.frame.ToGeodetic(epochs[k].p_m);
    if (exchanged) std::swap(point.lat_rad, point.lon_rad);
    return point;
  };
  double misfit = 0.0, n = 0.0;
  for (std::size_t i = 0, j = 0; i < epochs.size(); i = j) {
    while (j < epochs.size() && epochs[j].t_s - epochs[i].t_s < leg_s) ++j;
    if (j == epochs.size()) break;
    const auto way = WayBetween(epochs, i, j);
    if (!way) continue;
    const Eigen::Vector2d moved = LocalFrame(place(i)).ToMap(place(j)).head<2>();
    misfit += ((moved - *way) / (epochs[j].t_s - epochs[i].t_s)).squaredNorm();
    n += 1.0;
  }
  return n > 0.0 ? std::sqrt(misfit / n) : 0.0;
}

bool CanExchange(const Flight& flight) {
  const auto& epochs = flight.gnss->epochs;
  return std::all_of(epochs.begin(), epochs.end(), [&](const MapGnssEpoch& epoch) {
    return std::abs(flight.frame.ToGeodetic(epoch.p_m).lon_rad) <= 0.5 * std::numbers::pi;
  });
}

/// Returns the speed between the first position and the one farthest from it, m/s. Positions at
/// rest have a small one, whatever their noise.
double OverallSpeed(const std::vector<MapGnssEpoch>& epochs) {
  const MapGnssEpoch* farthest = &epochs.front();
  double most_m = 0.0;
  for (const MapGnssEpoch& epoch : epochs) {
    const double way_m = (epoch.p_m - epochs.front().p_m).head<2>().norm();
    if (way_m <= most_m) continue;
    most_m = way_m;
    farthest = &epoch;
  }
  const double time_s = farthest->t_s - epochs.front().t_s;
  return time_s > 0.0 ? most_m / time_s : 0.0;
}

void HintVelocities(const Flight& flight, std::vector<DataHint>* hints) {
  const auto& epochs = flight.gnss->epochs;
  const bool known = std::any_of(epochs.begin(), epochs.end(), [](const MapGnssEpoch& epoch) {
    return epoch.velocity_enu_mps.has_value();
  });
  if (!known) return;
  const double stated_mps = RmsSpeed(epochs);
  const double speed_mps = std::max(stated_mps, OverallSpeed(epochs));
  if (speed_mps < 1.0) return;
  const double as_is = VelocityMisfit(flight, speed_mps, false);
  if (as_is < 0.5 * speed_mps) return;
  if (CanExchange(flight) && VelocityMisfit(flight, speed_mps, true) < 0.5 * as_is) {
    hints->push_back(
        {"the GNSS positions fit their velocities when latitude and longitude are "
         "exchanged: put latitude first in gnss.file",
         "", ""});
    return;
  }
  hints->push_back({fmt::format("the motion of the GNSS positions differs by {:.3g} m/s rms from "
                                "their velocities of {:.3g} m/s rms: are these east, north, up, in "
                                "m/s?",
                                as_is, stated_mps),
                    "gnss.use_velocity", "false"});
}

void HintCoordinates(const Flight& flight, std::vector<DataHint>* hints) {
  if (flight.config.origin) {
    const double far_m = flight.gnss->epochs.front().p_m.norm();
    if (far_m > kFarOriginM) {
      hints->push_back({fmt::format("frame.origin_deg_m lies {:.0f} km from the first GNSS "
                                    "position: is it from another project, or are its latitude and "
                                    "longitude exchanged?",
                                    far_m / 1e3),
                        "frame.origin_deg_m", "~"});
    }
  }
  if (LooksLikeRadians(flight.frame.ToGeodetic(flight.gnss->epochs.front().p_m))) {
    hints->push_back(
        {"latitude and longitude of gnss.file look like radians (as degrees they lie "
         "at sea, off Ghana): multiply them by 57.29577951308232",
         "", ""});
    return;
  }
  HintVelocities(flight, hints);
}

/// Compares the columns of a text trajectory with those that fit the course.
void HintAttitude(const Flight& flight, std::vector<DataHint>* hints) {
  if (!flight.trajectory || !flight.config.trajectory) return;
  const TrajectoryConfig& config = *flight.config.trajectory;
  const FileContent content = InspectFile(flight.config.folder / config.file);
  if (content.kind != FileKind::kTrajectory || !content.trajectory) return;
  if (content.columns.empty() && !config.columns.names.empty()) return;
  const std::string file = "the attitudes of " + config.file + " follow the course ";
  if (!content.columns.empty() && config.columns.names.empty()) {
    hints->push_back({file + "in another order of the columns: " + content.why,
                      "trajectory.columns", FormatColumnNames(content.columns)});
    return;
  }
  // Without motion, the content says no more than the default.
  const TrajectoryColumns::Attitude found = content.trajectory->attitude;
  if (found == config.columns.attitude || found == TrajectoryColumns::Attitude::kQuaternionNed) {
    return;
  }
  hints->push_back({file + "in another convention", "trajectory.attitude", AttitudeWord(found)});
}

void HintPairs(const Flight& flight, std::vector<DataHint>* hints) {
  const std::optional<double> offset_s = FindPairClockOffset(flight);
  const std::string text =
      offset_s ? PairClockText(flight, *offset_s) : PairMistakeText(FindPairMistake(flight));
  if (!text.empty()) hints->push_back({text, "", ""});
}

}  // namespace

std::string AxesName(const Eigen::Matrix3d& R_imu_to_body) {
  std::string name;
  for (int axis = 0; axis < 3; ++axis) name += Letter(R_imu_to_body.col(axis));
  return name;
}

const char* AttitudeWord(TrajectoryColumns::Attitude attitude) {
  switch (attitude) {
    case TrajectoryColumns::Attitude::kQuaternionNed:
      break;
    case TrajectoryColumns::Attitude::kQuaternionEnu:
      return "quaternion_enu";
    case TrajectoryColumns::Attitude::kRollPitchHeading:
      return "roll_pitch_heading_deg";
    case TrajectoryColumns::Attitude::kRollPitchYawEnu:
      return "roll_pitch_yaw_enu_deg";
  }
  return "quaternion_ned";
}

std::string HintText(const DataHint& hint) {
  return hint.key.empty() ? hint.text : hint.text + "; set " + hint.key + ": " + hint.value;
}

std::string HintText(const AxesMistake& mistake) {
  using Sensor = AxesMistake::Sensor;
  if (mistake.sensor == Sensor::kBoth) {
    return "the axes of imu.file are left-handed: one has the wrong sign, or two are exchanged, in "
           "rates and specific forces alike; correct these columns";
  }
  const double scale = mistake.M.cwiseAbs().maxCoeff();
  if (scale != 1.0) {
    return fmt::format(
        "the angular rates of imu.file are plausible in {}; correct imu.rate_unit or the file",
        scale > 1.0 ? "rad/s, not deg/s" : "deg/s, not rad/s");
  }
  if (mistake.sensor == Sensor::kAccel && mistake.M.trace() < -2.0) {
    return "the specific forces of imu.file have the wrong sign (at rest they point up), or "
           "gnss.file is mirrored: latitude and longitude exchanged, or the sign of one wrong";
  }
  std::string reversed, exchanged;
  for (int axis = 0; axis < 3; ++axis) {
    if (mistake.M(axis, axis) < 0.0) reversed += kXyz[axis];
    if (mistake.M(axis, axis) == 0.0) exchanged += kXyz[axis];
  }
  std::string what = "all signs reversed";
  if (!exchanged.empty())
    what = fmt::format("axes {} and {} exchanged", exchanged[0], exchanged[1]);
  if (reversed.size() == 1) what = fmt::format("the sign of axis {} reversed", reversed);
  return fmt::format("the {} of imu.file fit with {}; correct these columns",
                     mistake.sensor == Sensor::kGyro ? "angular rates" : "specific forces", what);
}

std::string MatrixText(const Eigen::Matrix3d& matrix) {
  const auto number = [&](int i, int j) { return FormatDouble(matrix(i, j) + 0.0); };  // no -0
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text +=
        fmt::format("{}[{}, {}, {}]", i > 0 ? ", " : "[", number(i, 0), number(i, 1), number(i, 2));
  }
  return text + "]";
}

DataAgreement FindDataAgreement(const Flight& flight, int threads) {
  DataAgreement agreement;
  if (!flight.imu) return agreement;
  agreement.directions = Reliable(FindBodyDirections(flight, threads));
  if (flight.gnss && !flight.gnss->epochs.empty()) agreement.turns = CompareTurns(flight);
  agreement.lag = FindGnssLag(flight);
  return agreement;
}

bool DoubtsPoses(const DataHint& hint) { return hint.doubts_poses; }

bool IsClockHint(const DataHint& hint) {
  return hint.key == "gnss.time_offset_s" || hint.key == "imu.time_offset_s";
}

std::vector<DataHint> DataHints(const Flight& flight, const DataAgreement& agreement) {
  std::vector<DataHint> hints;
  if (flight.gnss && !flight.gnss->epochs.empty()) HintCoordinates(flight, &hints);
  if (!HintMirror(agreement, &hints)) HintClock(flight, agreement, &hints);
  if (agreement.directions) HintAxes(flight, *agreement.directions, &hints);
  std::vector<DataHint> trajectory = TrajectoryHints(flight, agreement);
  if (trajectory.empty()) HintAttitude(flight, &hints);
  // Poses with a wrong clock make the right one of the pairs and strips look wrong.
  for (DataHint& hint : trajectory) hint.doubts_poses = true;
  for (DataHint& hint : hints) hint.doubts_poses = !flight.trajectory && IsClockHint(hint);
  hints.insert(hints.end(), trajectory.begin(), trajectory.end());
  if (std::none_of(hints.begin(), hints.end(), DoubtsPoses)) HintPairs(flight, &hints);
  return hints;
}

}  // namespace dn::apps
