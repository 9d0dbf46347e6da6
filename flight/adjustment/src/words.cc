#include <dn/adjustment/words.h>
#include <dn/axis_names.h>
#include <dn/geo/text_table.h>
#include <dn/gnss/gnss_process.h>
#include <dn/report/value_words.h>
#include <dn/rotation.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

std::string P(double p_value) {
  return p_value < 1e-12 ? "p < 1e-12" : fmt::format("p = {:.1g}", p_value);
}

std::string Values(const EffectCheck& effect) {
  std::string text;
  for (Eigen::Index i = 0; i < effect.estimate.size(); ++i) {
    text += (i > 0 ? ", " : "") + FormatWithSigma(effect.estimate[i], effect.sigma[i]);
  }
  return text + " " + effect.unit;
}

std::string Triple(const Eigen::Vector3d& rad) {
  return fmt::format("{:.5f}, {:.5f}, {:.5f} deg", rad.x() * kDegPerRad, rad.y() * kDegPerRad,
                     rad.z() * kDegPerRad);
}

bool StartsWith(const std::string& text, const char* prefix) { return text.rfind(prefix, 0) == 0; }

/// Returns the key or the file that states too small a noise for a group.
std::string LargerNoise(const std::string& group) {
  if (StartsWith(group, "lidar p2p")) return "lidar.sigma_p_m is too small";
  if (StartsWith(group, "lidar surface")) {
    return "the sigmas of the surface pairs are too small (lidar.surface_pairs)";
  }
  if (StartsWith(group, "gnss error")) return "the sigmas of gnss.processes are too small";
  if (StartsWith(group, "gnss velocity")) {
    return "the sigmas of gnss.file are too small (gnss.velocity_sigma_scale)";
  }
  if (StartsWith(group, "gnss")) return "the sigmas of gnss.file are too small (gnss.sigma_scale)";
  const bool gyro = StartsWith(group, "gyro") || StartsWith(group, "inertial gyro");
  const bool accel = StartsWith(group, "accel") || StartsWith(group, "inertial");
  if (gyro) return "the noise under imu.gyro is too small";
  if (accel) return "the noise under imu.accel is too small";
  return "their noise is too small";
}

/// Returns the likely cause of errors that residuals share, with a remedy.
std::string SharedErrorCause(const CommonErrorCheck& common) {
  if (StartsWith(common.name, "lidar p2p, over pairs of strips")) {
    return fmt::format("strips {} disagree most; check their pair file and the trajectory there",
                       common.worst);
  }
  if (StartsWith(common.group, "lidar p2p")) {
    return "neighbouring pairs are not independent: thin them (lidar.pairs), or check the "
           "matching";
  }
  if (StartsWith(common.group, "lidar surface")) {
    return "strips see smooth ground at different heights: check the ranges, or leave out "
           "lidar.surface_pairs";
  }
  if (StartsWith(common.group, "gnss")) {
    return "the GNSS errors are time-correlated (gnss_correlated_noise): state them under "
           "gnss.processes";
  }
  return LargerNoise(common.group) + ", or a bias process is missing";
}

std::string Say(const facts::EffectPresent& fact) {
  const EffectCheck& effect = fact.effect;
  std::string text =
      fmt::format("the data indicate {} = {} ({})", effect.name, Values(effect), P(effect.p_value));
  const Eigen::Vector3d mdeg = effect.boresight_rad * kDegPerRad * 1e3;
  text += fact.moves_boresight
              ? fmt::format(", which moves the boresight by {:.3g}, {:.3g}, {:.3g} mdeg", mdeg.x(),
                            mdeg.y(), mdeg.z())
              : std::string(", which moves the trajectory");
  text += fmt::format(" ({:.1f} sigma)", effect.max_shift_sigmas);
  if (!effect.inseparable_from.empty()) {
    text += fmt::format("; {} would explain the data nearly as well",
                        fmt::join(effect.inseparable_from, " or "));
  }
  return text + ": " + effect.remedy;
}

std::string Say(const facts::UnmodelledDiscrepancy& fact) {
  const DiscrepancyCheck& discrepancy = fact.discrepancy;
  return fmt::format(
      "{} show a discrepancy that no known effect explains ({}); it may move the boresight by "
      "{:.1f} sigma: run dn gap to locate it, and check the scanner's calibration and the pairs",
      discrepancy.name, P(discrepancy.p_value), discrepancy.max_shift_sigmas);
}

std::string Say(const facts::UnknownAmbiguous& fact) {
  const CompetingEffectCheck& check = fact.check;
  const Eigen::Vector3d mdeg = check.boresight_rad * kDegPerRad * 1e3;
  return fmt::format(
      "{} instead of {} explains the data equally well, and {} ({:.1f} sigma): find out which one "
      "is present (dn gap says which flight would separate them), or estimate both, so that the "
      "sigmas include the choice",
      check.competing_effect, check.unknown,
      fact.moves_boresight ? fmt::format("moves the boresight by {:.3g}, {:.3g}, {:.3g} mdeg",
                                         mdeg.x(), mdeg.y(), mdeg.z())
                           : std::string("moves the trajectory"),
      check.max_shift_sigmas);
}

std::string Say(const facts::VarianceTooLarge& fact) {
  const GroupCheck& group = fact.group;
  return fmt::format(
      "the residuals of {} have {:.2f} times the variance that their stated noise allows ({}){}: "
      "{}, or something is not modelled",
      group.name, group.variance_ratio, P(group.p_value),
      group.worst_standardised != 0.0 ? fmt::format(", the worst at t = {:.3f} s", group.worst_t_s)
                                      : std::string(),
      LargerNoise(group.name));
}

std::string Say(const facts::ErrorsShared& fact) {
  const CommonErrorCheck& common = fact.common;
  return fmt::format(
      "the residuals of {} share errors of about {:.2g} sigma, although the model assumes that "
      "they are independent ({}); these errors may move the result by {:.1f} sigma{}: {}",
      common.name, common.sigma, P(common.p_value), common.max_shift_sigmas,
      common.covered ? ", which the reported sigmas contain" : "", SharedErrorCause(common));
}

std::string Say(const facts::PriorContradicted& fact) {
  const PriorCheck& prior = fact.prior;
  const std::string key = prior.unknown == "boresight"
                              ? "lidar.boresight_deg with lidar.boresight_sigma_deg"
                          : prior.unknown == "control_datum_shift"
                              ? "control.datum_shift_sigma_m"
                              : "the sigma of " + prior.unknown + " under estimate";
  return fmt::format(
      "the stated prior of {} contradicts all other data by {:.1f} sigma ({}): check {}",
      prior.unknown, std::sqrt(prior.statistic / prior.dof), P(prior.p_value), key);
}

std::string Say(const facts::VectorsAssumed& fact) {
  return fmt::format(
      "the laser vectors{} were computed from points with an assumed boresight, {}: the angles "
      "make "
      "the strips consistent, but are the mounting's only if the points were georeferenced with "
      "that one; state it in flight.yaml, lidar.georeferenced_with: {{boresight_deg: [roll, pitch, "
      "yaw]}}, and match the strips again",
      fact.files.empty() ? "" : " of " + fact.files, Triple(fact.boresight_rad));
}

std::string Say(const facts::GapUnexplained& fact) {
  return fmt::format(
      "a diagnosis of the flight found a discrepancy that its configuration does not model: {} "
      "(key "
      "unexplained of flight.yaml): model it, diagnose the flight again, then remove that key",
      fact.what);
}

std::string Say(const facts::MountingImpossible& fact) {
  const Eigen::Vector3d deg = fact.angles_rad * kDegPerRad;
  return fmt::format(
      "the estimated boresight is {:.1f}, {:.1f}, {:.1f} deg, which is too large for a mounting: "
      "check lidar.R_sensor_to_body, lidar.boresight_deg and the key body",
      deg.x(), deg.y(), deg.z());
}

std::string Say(const facts::UpsideDown&) {
  return "the body is upside down for the whole flight: set body: FLU if its axes are "
         "forward-left-up, otherwise check imu.R_imu_to_body";
}

std::string Say(const facts::Sigma0TooLarge& fact) {
  return fmt::format(
      "sigma0 is {:.1f}: the residuals exceed their stated noise by this factor; check units, "
      "axes, lever arms, time tags and the stochastic model",
      fact.sigma0);
}

std::string Say(const facts::PairsLeftOut& fact) {
  return fmt::format(
      "{:.0f} % of the pairs contradict the others and were left out: check the matching, and that "
      "lidar.p2p belongs to this flight",
      100.0 * fact.share);
}

std::string Say(const facts::GnssLeftOut& fact) {
  return fmt::format(
      "{:.0f} % of the GNSS epochs contradict all other data and were left out: check gnss.file, "
      "its time tags, sigmas and the lever arm",
      100.0 * fact.share);
}

std::string Say(const facts::GnssRunDoubtful& fact) {
  const GnssRunCheck& run = fact.run;
  return fmt::format(
      "{} GNSS positions in a row (t = {:.3f} to {:.3f} s) contradict the inertial data and were "
      "left out, but {} (with these positions, the {} moves by {:.1f} sigma): look for vibration "
      "or lost rows in the inertial data at that time, and for a slow drift of GNSS; dn gap tests "
      "both, and time_span_s can exclude that time",
      run.positions, run.t0_s, run.t1_s,
      run.is_inertial() ? "their deviations are as smooth as errors of the inertial data"
                        : "their deviations do not tell which of the two sensors is wrong",
      fact.moves_boresight ? "boresight" : "trajectory", run.max_shift_sigmas);
}

double RoundToTenthMillimetre(double value) { return std::round(value * 1e4) / 1e4; }

std::string Say(const facts::GnssLeverArmOff& fact) {
  const Eigen::Vector3d& by_m = fact.correction_b_m;
  return fmt::format(
      "the innovations of the GNSS positions indicate a correction of gnss.lever_arm_m by about "
      "[{}, {}, {}] m (forward, right, down): check its sign and axes, or estimate gnss_lever_arm",
      FormatDouble(RoundToTenthMillimetre(by_m[0])), FormatDouble(RoundToTenthMillimetre(by_m[1])),
      FormatDouble(RoundToTenthMillimetre(by_m[2])));
}

std::string Say(const facts::GnssTimeOff& fact) {
  const bool drifts = fact.clock.shows_drift();
  const bool late = !drifts || fact.clock.shows_offset();
  const ClockEstimate clock = !drifts ? fact.clock.WithoutDrift()
                              : late  ? fact.clock
                                      : fact.clock.WithoutOffset();
  std::vector<std::string> off, names;
  if (late) {
    off.push_back(fmt::format("are {} s {}",
                              FormatWithSigma(std::abs(clock.offset_s), clock.sigma_offset_s),
                              clock.offset_s > 0.0 ? "late" : "early"));
    names.push_back(EffectName(EffectId::kGnssTimeOffset));
  }
  if (drifts) {
    off.push_back(fmt::format("drift by {} ppm",
                              FormatWithSigma(clock.drift * 1e6, clock.sigma_drift * 1e6)));
    names.push_back(EffectName(EffectId::kGnssTimeDrift));
  }
  return fmt::format(
      "the GNSS time tags {} against those of the inertial data, which moves the {} ({:.1f} "
      "sigma): check the time systems of imu.file and gnss.file and correct the tags "
      "(for a constant offset, add it to gnss.time_offset_s, early as negative), or estimate {}",
      fmt::join(off, " and "), fact.moves_boresight ? "boresight" : "trajectory",
      fact.max_shift_sigmas, fmt::join(names, " and "));
}

std::string Say(const facts::InnovationSize& fact) {
  return fmt::format(
      "the innovations of the {} are {} times as large as the model expects: {}", fact.sensor,
      FormatDouble(std::round(fact.ratio * 100.0) / 100.0),
      fact.ratio > 1.0
          ? "the stated sigmas or the inertial noise are too small, or something is not modelled; "
            "the covariances are then also too small"
          : "the stated sigmas are too large, or the errors are correlated in time");
}

/// Rounds to two digits, which is the accuracy of the test.
double Rounded(double value) { return value > 0.0 ? std::stod(fmt::format("{:.1e}", value)) : 0.0; }

GnssProcess Rounded(GnssProcess process) {
  for (double& sigma_m : process.sigma_enu_m) sigma_m = Rounded(sigma_m);
  process.tau_s = Rounded(process.tau_s);
  return process;
}

std::string Say(const facts::GnssErrorsCorrelated& fact) {
  const GnssCorrelation& test = fact.test;
  const GnssProcess process = Rounded(test.process);
  return fmt::format(
      "the GNSS positions have time-correlated errors: the lag-1 correlation of their residuals is "
      "{:.2f}, {:.2f}, {:.2f} (east, north, up), and white noise would give {:.2f}, {:.2f}, {:.2f} "
      "({}). A process of {:g} s and {:g}, {:g}, {:g} m fits them. Unless the inertial "
      "noise is stated too small, add to flight.yaml gnss.processes: [{}]; without it the "
      "covariances are too small",
      test.lag1.x(), test.lag1.y(), test.lag1.z(), test.lag1_expected.x(), test.lag1_expected.y(),
      test.lag1_expected.z(), P(std::min(test.p_value_together, test.p_value.minCoeff())),
      process.tau_s, process.sigma_enu_m.x(), process.sigma_enu_m.y(), process.sigma_enu_m.z(),
      FormatGnssProcess(process));
}

std::string Say(const facts::SigmaTooLarge& fact) {
  return fmt::format(
      "the standard deviation of {} exceeds 0.5 deg: more pairs, more overlapping strips, or a "
      "better attitude are needed",
      kRollPitchYaw[fact.angle]);
}

std::string Say(const facts::SigmaAbovePairs& fact) {
  return fmt::format(
      "the standard deviation of {} exceeds ten times the resolution of a single pair: more "
      "overlapping strips are needed",
      kRollPitchYaw[fact.angle]);
}

std::string Say(const facts::AnglesInseparable& fact) {
  return fmt::format(
      "{} and {} cannot be separated: add a cross strip or a strip at another height",
      kRollPitchYaw[fact.first], kRollPitchYaw[fact.second]);
}

std::string Say(const facts::TrajectoryEstimated&) {
  return "the trajectory and its time-correlated errors are estimated with the boresight";
}

const char* Say(facts::AttitudeInPairs::Size size) {
  switch (size) {
    case facts::AttitudeInPairs::Size::kNoise:
      return "noise level";
    case facts::AttitudeInPairs::Size::kCovered:
      return "tactical grade or better, covered by the stated sigmas";
    case facts::AttitudeInPairs::Size::kAbsorbed:
      break;
  }
  return "the angles contain that error and make the cloud consistent, but are not those of the "
         "mounting; the dynamic network separates the two";
}

std::string Say(const facts::AttitudeInPairs& fact) {
  return fmt::format(
      "the attitude error of the trajectory ({}) changes the {} by {:.3f} m at a range of {:.0f} "
      "m, against its own sigma of {:.3f} m: {}",
      Triple(fact.sigma_rph_rad),
      fact.of_planes ? "distance of a point from its plane" : "difference of a pair", fact.change_m,
      fact.range_m, fact.pair_sigma_m, Say(fact.size));
}

std::string Say(const facts::StripsAlike& fact) {
  return fmt::format(
      "only {} strip{}{}: yaw is more reliable with four parallel strips, or with three if one "
      "crosses the others or has another height",
      fact.strips, fact.strips == 1 ? "" : "s",
      fact.strips == 3 ? ", parallel and at one height" : "");
}

std::string Say(const facts::FewPairs& fact) {
  return fmt::format("only {} pairs: the result needs tens of pairs to be reliable", fact.pairs);
}

std::string Say(const facts::SigmasWidened& fact) {
  std::string text = fmt::format(
      "the reliable sigmas are {:.1f}, {:.1f} and {:.1f} times those of the normal matrix "
      "(sigma_scaled_deg: {}), which assume independent trajectory errors at every epoch",
      fact.ratio.x(), fact.ratio.y(), fact.ratio.z(), Triple(fact.scaled_rad));
  if (fact.tau_stated) {
    return text + fmt::format(
                      "; according to {} they are time-correlated, and contribute {} to the sigmas",
                      fact.source, Triple(fact.correlated_rad));
  }
  text += fmt::format(
      "; a constant attitude error of {} in roll, pitch and yaw, as stated by {}, is absorbed "
      "without showing",
      Triple(fact.constant_rad), fact.source);
  if (fact.tau_shown) {
    text += fmt::format(
        ", and the pairs show errors with a correlation time of about {:.0f} s, which contribute "
        "{} to the sigmas",
        fact.tau_s, Triple(fact.correlated_rad));
  }
  return text;
}

std::string Say(const facts::NotEstimated& fact) {
  return fact.unknown + " is not estimated: " + fact.because;
}

/// Returns the components of a control point, each with its sigma: "E 0.512(0.021) m".
std::string Components(const ControlPointCheck& point) {
  static const char* const kAxes[] = {"E", "N", "U"};
  const Eigen::VectorXd sigma_m = point.covariance_m2.diagonal().cwiseSqrt();
  std::vector<std::string> parts;
  for (Eigen::Index k = 0; k < point.residual_m.size(); ++k) {
    const char* axis = point.horizontal() ? kAxes[k] : point.vertical() ? "U" : "along its normal";
    parts.push_back(fmt::format("{} {}", axis, FormatWithSigma(point.residual_m[k], sigma_m[k])));
  }
  return fmt::format("{} m", fmt::join(parts, ", "));
}

std::string Say(const facts::ControlPointWrong& fact) {
  const ControlPointCheck& point = fact.point;
  const bool check = point.role == ControlPointCheck::Role::kCheck;
  return fmt::format(
      "{} {} contradicts all other data (statistic {:.1f} with {} degrees of freedom, {}): laser "
      "minus survey is {}{}; check its coordinates and its laser vector ({})",
      check ? "check" : "control point", point.name, point.statistic, point.dof, P(point.p_value),
      Components(point),
      point.role == ControlPointCheck::Role::kRejected ? ", and it was left out" : "", point.where);
}

std::string Say(const facts::ControlShifted& fact) {
  const ControlShift& shift = fact.shift;
  return fmt::format(
      "the coordinates of the control exceed those of GNSS by a constant E {}, N {}, U {} m ({}): "
      "check whether both have the same datum and ellipsoidal heights, or state "
      "control.datum_shift_sigma_m",
      FormatWithSigma(shift.shift_m.x(), shift.sigma_m.x()),
      FormatWithSigma(shift.shift_m.y(), shift.sigma_m.y()),
      FormatWithSigma(shift.shift_m.z(), shift.sigma_m.z()), P(shift.p_value));
}

std::string Say(const facts::ControlLeftOut& fact) {
  return fmt::format(
      "{} of {} control points contradict all other data and were left out: check the coordinate "
      "system of the control (control.crs), its epochs and its sigmas",
      fact.left_out, fact.points);
}

std::string Say(const facts::NetworkDiffers& fact) {
  return fmt::format("differs from the dynamic network by {} (p = {:.2g}): {}",
                     Triple(fact.difference_rad), fact.p_value,
                     fact.contradicts
                         ? "more than their covariances explain, so the trajectory has an attitude "
                           "error above its stated sigma, and the angles of the network are "
                           "those of the mounting"
                         : "within what their covariances explain");
}

}  // namespace

const char* Word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kCalibrated:
      return "calibrated";
    case Verdict::kAbsorbed:
      return "absorbed";
    case Verdict::kNotObservable:
      return "not_observable";
    case Verdict::kContradicted:
      break;
  }
  return "contradicted";
}

std::string Words(const Finding& finding) {
  return std::visit([](const auto& fact) { return Say(fact); }, finding.fact);
}

std::vector<std::string> Words(const std::vector<Finding>& findings) {
  std::vector<std::string> texts;
  for (const Finding& finding : findings) texts.push_back(Words(finding));
  return texts;
}

}  // namespace dn
