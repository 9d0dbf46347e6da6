#include <dn/median.h>
#include <dn/navigation/attitude_agreement.h>
#include <dn/rotation.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "motion_record.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using MistakeKind = AttitudeMistake::Kind;

// Turns over shorter steps would be noise, over longer ones they would be averaged.
constexpr double kTurnStepS = 0.2, kLongestTurnStepS = 2.0;
constexpr std::size_t kMostTurns = 4000, kFewestTurns = 50;
// Attitudes that leave less of the turns are right. A mistake must leave this share of what they
// leave as read at most, and much less than the turns.
constexpr double kRightMisfit = 0.2, kExplains = 0.4, kGoodMisfit = 0.5;

// Rms of the differences of the turns over that of the turns, at most.
constexpr double kSameTurns = 0.6;

/// A step of the trajectory, with the turn of the gyros in body.
struct TurnStep {
  Quaterniond q0_nb, q1_nb;
  Vector3d gyro_radps;
  double step_s;
};

bool InGap(const ImuData& imu, double t0_s, double t1_s) {
  return std::any_of(imu.gaps.begin(), imu.gaps.end(),
                     [&](const ImuGap& gap) { return gap.t_begin_s < t1_s && gap.t_end_s > t0_s; });
}

std::vector<TurnStep> TurnSteps(const Flight& flight, double shift_s) {
  const navigation_internal::MotionRecord motion(*flight.imu);
  const std::vector<NavPoint>& points = flight.trajectory->points();
  const auto steps =
      static_cast<std::size_t>((points.back().t_s - points.front().t_s) / kTurnStepS);
  const std::size_t every = steps / kMostTurns + 1;
  std::vector<TurnStep> turns;
  std::size_t seen = 0;
  for (std::size_t i = 0, j = 0; i < points.size(); i = j) {
    while (j < points.size() && points[j].t_s - points[i].t_s < kTurnStepS) ++j;
    if (j == points.size()) break;
    const double t0_s = points[i].t_s - shift_s, t1_s = points[j].t_s - shift_s;
    const bool covered = t0_s >= motion.t_begin_s() && t1_s <= motion.t_end_s() &&
                         t1_s - t0_s <= kLongestTurnStepS && !InGap(*flight.imu, t0_s, t1_s);
    if (!covered || seen++ % every != 0) continue;
    const Matrix3d R = motion.At(t0_s).R_rb.transpose() * motion.At(t1_s).R_rb;
    turns.push_back(
        {points[i].q_nb, points[j].q_nb, Log(Quaterniond(R)) / (t1_s - t0_s), t1_s - t0_s});
  }
  return turns;
}

using Correction = std::function<Quaterniond(const Quaterniond&)>;

Vector3d Variances(const std::vector<Vector3d>& rows) {
  Vector3d sum = Vector3d::Zero(), sum2 = Vector3d::Zero();
  for (const Vector3d& row : rows) {
    sum += row;
    sum2 += row.cwiseAbs2();
  }
  const double n = static_cast<double>(rows.size());
  return sum2 / n - (sum / n).cwiseAbs2();
}

std::vector<Vector3d> Changes(const std::vector<Vector3d>& rows) {
  std::vector<Vector3d> changes;
  for (std::size_t k = 1; k < rows.size(); ++k) changes.push_back(rows[k] - rows[k - 1]);
  return changes;
}

/// Returns the root of the share of the rates that the corrected attitudes leave, each axis with
/// the same weight. changes: of the changes of the rates. These are not hidden by long turns.
double TurnMisfit(const std::vector<TurnStep>& turns, const Correction& correct, bool changes) {
  std::vector<Vector3d> gyro_radps, left_radps;
  for (const TurnStep& turn : turns) {
    const Quaterniond q = correct(turn.q0_nb).conjugate() * correct(turn.q1_nb);
    gyro_radps.push_back(turn.gyro_radps);
    left_radps.push_back(turn.gyro_radps - Log(q) / turn.step_s);
  }
  const Vector3d all = Variances(changes ? Changes(gyro_radps) : gyro_radps);
  const Vector3d left = Variances(changes ? Changes(left_radps) : left_radps);
  return all.minCoeff() > 0.0 ? std::sqrt(left.cwiseQuotient(all).mean()) : 0.0;
}

/// Returns an attitude with changed roll, pitch and heading.
Correction WithAngles(const std::function<Vector3d(const Vector3d&)>& change) {
  return [change](const Quaterniond& q_nb) {
    const Matrix3d R = q_nb.toRotationMatrix();
    const Vector3d rph(std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
                       std::atan2(R(1, 0), R(0, 0)));
    const Vector3d right = change(rph);
    return Quaterniond(Eigen::AngleAxisd(right.z(), Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(right.y(), Vector3d::UnitY()) *
                       Eigen::AngleAxisd(right.x(), Vector3d::UnitX()));
  };
}

/// Returns the 23 rotations between parallel axes that are not the identity.
std::vector<Matrix3d> AxesTurns() {
  std::vector<Matrix3d> turns;
  for (const auto& [x, y] : {std::pair{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}}) {
    for (int signs = 0; signs < 4; ++signs) {
      Matrix3d R;
      R.col(0) = (signs % 2 == 0 ? 1.0 : -1.0) * Vector3d::Unit(x);
      R.col(1) = (signs < 2 ? 1.0 : -1.0) * Vector3d::Unit(y);
      R.col(2) = R.col(0).cross(R.col(1));
      if (!R.isIdentity()) turns.push_back(R);
    }
  }
  return turns;
}

std::vector<std::pair<AttitudeMistake, Correction>> PossibleMistakes() {
  std::vector<std::pair<AttitudeMistake, Correction>> all{
      {{MistakeKind::kRollSign},
       WithAngles([](const Vector3d& a) { return Vector3d(-a.x(), a.y(), a.z()); })},
      {{MistakeKind::kPitchSign},
       WithAngles([](const Vector3d& a) { return Vector3d(a.x(), -a.y(), a.z()); })},
      {{MistakeKind::kHeadingSign},
       WithAngles([](const Vector3d& a) { return Vector3d(a.x(), a.y(), -a.z()); })},
      {{MistakeKind::kRollPitchExchanged},
       WithAngles([](const Vector3d& a) { return Vector3d(a.y(), a.x(), a.z()); })},
      {{MistakeKind::kInverse}, [](const Quaterniond& q) { return q.conjugate(); }}};
  for (const Matrix3d& R_turn : AxesTurns()) {
    all.push_back({{MistakeKind::kAxes, R_turn},
                   [q_turn = Quaterniond(R_turn)](const Quaterniond& q) { return q * q_turn; }});
  }
  return all;
}

std::optional<AttitudeMistake> Explain(const std::vector<TurnStep>& turns, bool changes) {
  const double as_read = TurnMisfit(
      turns, [](const Quaterniond& q) { return q; }, changes);
  if (as_read < kRightMisfit) return std::nullopt;
  AttitudeMistake best;
  best.misfit = as_read;
  for (const auto& [mistake, correct] : PossibleMistakes()) {
    const double misfit = TurnMisfit(turns, correct, changes);
    if (misfit >= best.misfit) continue;
    best = mistake;
    best.misfit = misfit;
  }
  best.misfit_as_read = as_read;
  if (best.misfit > std::min(kExplains * as_read, kGoodMisfit)) return std::nullopt;
  return best;
}

/// Returns the rates between the attitudes of a trajectory, without forces.
ImuData AttitudeRates(const std::vector<NavPoint>& points) {
  ImuData rates;
  for (std::size_t i = 1; i < points.size(); ++i) {
    ImuSample sample{points[i].t_s, points[i].t_s - points[i - 1].t_s};
    sample.w_ib_b_radps = Log(points[i - 1].q_nb.conjugate() * points[i].q_nb) / sample.dt_s;
    rates.samples.push_back(sample);
  }
  std::vector<double> steps_s;
  for (const ImuSample& sample : rates.samples) steps_s.push_back(sample.dt_s);
  rates.nominal_dt_s = Median(steps_s);
  return rates;
}

}  // namespace

std::optional<AttitudeMistake> FindAttitudeMistake(const Flight& flight, double shift_s) {
  if (!flight.trajectory || !flight.imu) return std::nullopt;
  const std::vector<TurnStep> turns = TurnSteps(flight, shift_s);
  if (turns.size() < kFewestTurns) return std::nullopt;
  const std::optional<AttitudeMistake> found = Explain(turns, false);
  return found ? found : Explain(turns, true);
}

std::optional<UnitAgreement> CompareAttitudes(const Flight& flight) {
  if (!flight.trajectory || !flight.imu) return std::nullopt;
  const auto found = CompareUnits(*flight.imu, AttitudeRates(flight.trajectory->points()));
  const bool one_size = found && found->noise_radps < kSameTurns * found->motion_radps;
  return one_size ? found : std::nullopt;
}

}  // namespace dn
