#include "data_hints.h"

#include <dn/geo/text_table.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace dn::apps {
namespace {

// Directions scatter by more where the body turns over, or is carried about.
constexpr double kLeastAgreement = 0.8;
// An instrument is put in along the axes of its carrier, to better than this.
constexpr double kMostAxesDistanceRad = 35.0 * kRadPerDeg;
// Turns that are the same, seen by two sensors.
constexpr double kSameTurns = 0.9;
constexpr double kLeastGain = 0.1;
constexpr double kLeastLagS = 1.0;
// Leap seconds between GPS time and UTC, from 2006 on.
constexpr double kLeapSecondsFrom = 14.0, kLeapSecondsTo = 18.0;
// Where LocalFrame begins to lose digits.
constexpr double kFarOriginM = 1e5;

bool Agree(const BodyDirections& directions) {
  return directions.down_agreement >= kLeastAgreement &&
         (!directions.course_b || directions.course_agreement >= kLeastAgreement);
}

/// A signed axis of body by its letter.
char Letter(const Eigen::Vector3d& direction_b) {
  constexpr char kLetters[2][4] = {"FRD", "BLU"};
  Eigen::Index axis = 0;
  direction_b.cwiseAbs().maxCoeff(&axis);
  return kLetters[direction_b[axis] < 0.0 ? 1 : 0][axis];
}

/// The matrix that the file's key takes: that to forward-right-down, in the axes that `body` names.
Eigen::Matrix3d InDeclaredBody(const FlightConfig& config, Eigen::Matrix3d R) {
  if (config.body_is_flu) R.bottomRows<2>().array() = 0.0 - R.bottomRows<2>().array();
  return R;
}

void HintAxes(const Flight& flight, const BodyDirections& found, std::vector<DataHint>* hints) {
  const AxesFit fit = FitAxes(found);
  if (!Agree(found) || fit.distance_rad > kMostAxesDistanceRad || fit.R_turn.isIdentity()) return;
  const Eigen::Matrix3d R = fit.R_turn * flight.config.imu->read.R_imu_to_body;
  const std::string matrix = MatrixText(InDeclaredBody(flight.config, R));
  std::string text = fmt::format(
      "the inertial data are in axes {} (x y z; F forward, B back, R right, L left, D down, U up), "
      "taken as {}",
      AxesName(R), AxesName(flight.config.imu->read.R_imu_to_body));
  text += found.course_b ? " by flight.yaml: gravity and course say so"
                         : " by flight.yaml: gravity says so (the course tells nothing, forward is "
                           "a guess)";
  hints->push_back({text, "imu.R_imu_to_body", matrix});
}

std::string LagText(double lag_s) {
  return fmt::format("{:.4g} s {}", std::abs(lag_s), lag_s > 0.0 ? "late" : "early");
}

void HintLag(const Flight& flight, const TurnComparison& turns, std::vector<DataHint>* hints) {
  const double lag_s = turns.best_lag_s;
  const double whole_s = std::round(std::abs(lag_s));
  const bool leap = whole_s >= kLeapSecondsFrom && whole_s <= kLeapSecondsTo &&
                    std::abs(std::abs(lag_s) - whole_s) <= 0.5;
  const char* in_utc = lag_s < 0.0 ? "GNSS" : "inertial";
  std::string text = fmt::format(
      "the turns of the course fit those of the gyros when the GNSS tags are taken as {}",
      LagText(lag_s));
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

void HintTurns(const Flight& flight, const TurnComparison& turns, std::vector<DataHint>* hints) {
  if (turns.correlation < -kSameTurns) {
    hints->push_back(
        {"the course turns the other way than the gyros do: latitude and longitude may "
         "be exchanged in gnss.file, or an axis of imu.file has the wrong sign",
         "", ""});
    return;
  }
  const bool shifted = turns.best_correlation > kSameTurns &&
                       turns.best_correlation - turns.correlation > kLeastGain &&
                       std::abs(turns.best_lag_s) >= kLeastLagS;
  if (shifted) HintLag(flight, turns, hints);
}

/// As the file has them.
struct GeodeticEpoch {
  double t_s;
  Geodetic antenna;
  std::optional<Eigen::Vector3d> velocity_enu_mps;
};

std::vector<GeodeticEpoch> GeodeticEpochs(const Flight& flight) {
  std::vector<GeodeticEpoch> epochs;
  for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
    epochs.push_back({epoch.t_s, flight.frame.ToGeodetic(epoch.p_m), epoch.velocity_enu_mps});
  }
  return epochs;
}

/// Whether a latitude and longitude in deg lie where no land is, but numbers in radians do.
bool LooksLikeRadians(const Geodetic& point) {
  return std::abs(point.lat_rad * kDegPerRad) <= std::numbers::pi / 2.0 &&
         std::abs(point.lon_rad * kDegPerRad) <= std::numbers::pi;
}

/// Root mean square of what the positions move between epochs beyond what the velocities say, m/s,
/// with east and north of the positions as they are or exchanged.
double VelocityMisfit(const Flight& flight, bool exchanged, double* speed_mps) {
  const std::vector<GeodeticEpoch> epochs = GeodeticEpochs(flight);
  double misfit = 0.0, speed = 0.0, n = 0.0;
  for (std::size_t i = 1; i < epochs.size(); ++i) {
    const GeodeticEpoch &a = epochs[i - 1], &b = epochs[i];
    if (!a.velocity_enu_mps || !b.velocity_enu_mps || b.t_s - a.t_s > 5.0) continue;
    const auto map = [&](Geodetic point) {
      if (exchanged) std::swap(point.lat_rad, point.lon_rad);
      return point;
    };
    const LocalFrame frame(map(a.antenna));
    const Eigen::Vector3d moved_mps = frame.ToMap(map(b.antenna)) / (b.t_s - a.t_s);
    const Eigen::Vector3d said_mps = 0.5 * (*a.velocity_enu_mps + *b.velocity_enu_mps);
    misfit += (moved_mps - said_mps).head<2>().squaredNorm();
    speed += said_mps.head<2>().squaredNorm();
    n += 1.0;
  }
  *speed_mps = n > 0.0 ? std::sqrt(speed / n) : 0.0;
  return n > 0.0 ? std::sqrt(misfit / n) : 0.0;
}

bool CanExchange(const Flight& flight) {
  const std::vector<GeodeticEpoch> epochs = GeodeticEpochs(flight);
  return std::all_of(epochs.begin(), epochs.end(), [](const GeodeticEpoch& epoch) {
    return std::abs(epoch.antenna.lon_rad) <= 0.5 * std::numbers::pi;
  });
}

void HintVelocities(const Flight& flight, std::vector<DataHint>* hints) {
  double speed_mps = 0.0;
  const double as_is = VelocityMisfit(flight, false, &speed_mps);
  if (!(speed_mps > 1.0) || as_is < 0.5 * speed_mps) return;
  if (CanExchange(flight) && VelocityMisfit(flight, true, &speed_mps) < 0.5 * as_is) {
    hints->push_back(
        {"the GNSS positions fit their velocities when latitude and longitude are "
         "exchanged: put latitude first in gnss.file",
         "", ""});
    return;
  }
  hints->push_back({fmt::format("the GNSS positions move by {:.3g} m/s rms otherwise than their "
                                "velocities of {:.3g} m/s rms say: are these east, north, up, in "
                                "m/s?",
                                as_is, speed_mps),
                    "gnss.use_velocity", "false"});
}

void HintCoordinates(const Flight& flight, std::vector<DataHint>* hints) {
  if (flight.config.origin) {
    const double far_m = flight.gnss->epochs.front().p_m.norm();
    if (far_m > kFarOriginM) {
      hints->push_back({fmt::format("frame.origin_deg_m lies {:.0f} km from the first GNSS "
                                    "position: is it of another project, or are its latitude and "
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

}  // namespace

std::string AxesName(const Eigen::Matrix3d& R_imu_to_body) {
  std::string name;
  for (int axis = 0; axis < 3; ++axis) name += Letter(R_imu_to_body.col(axis));
  return name;
}

std::string TextOf(const DataHint& hint) {
  return hint.key.empty() ? hint.text : hint.text + "; set " + hint.key + ": " + hint.value;
}

std::string MatrixText(const Eigen::Matrix3d& matrix) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{}[{}, {}, {}]", i > 0 ? ", " : "[", FormatDouble(matrix(i, 0)),
                        FormatDouble(matrix(i, 1)), FormatDouble(matrix(i, 2)));
  }
  return text + "]";
}

DataAgreement FindDataAgreement(const Flight& flight) {
  DataAgreement agreement;
  if (!flight.imu) return agreement;
  agreement.directions = FindBodyDirections(flight);
  if (flight.gnss && !flight.gnss->epochs.empty()) agreement.turns = CompareTurns(flight);
  return agreement;
}

std::vector<DataHint> DataHints(const Flight& flight, const DataAgreement& agreement) {
  std::vector<DataHint> hints;
  if (flight.gnss && !flight.gnss->epochs.empty()) HintCoordinates(flight, &hints);
  if (agreement.turns) HintTurns(flight, *agreement.turns, &hints);
  if (agreement.directions) HintAxes(flight, *agreement.directions, &hints);
  return hints;
}

}  // namespace dn::apps
