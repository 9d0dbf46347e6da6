#include "model_findings.h"

#include <dn/rotation.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dn {
namespace internal {
namespace {

using Kind = Finding::Kind;

// An error of this many sigmas of the boresight is one that its covariance does not cover.
constexpr double kDamageInSigmas = 1.0;
// Noise may be stated wrong by a factor of 1.4; more is another cause.
constexpr double kLargestVarianceRatio = 2.0;
constexpr double kLargestSigma0 = 3.0;
constexpr double kPairsLeftOut = 0.3;
constexpr double kGnssLeftOut = 0.1;
constexpr double kLargestBoresightDeg = 15.0;
constexpr double kUpsideDownShare = 0.9;
constexpr double kCertain = std::numeric_limits<double>::infinity();

std::string P(double p_value) {
  return p_value < 1e-12 ? "p < 1e-12" : fmt::format("p = {:.1g}", p_value);
}

std::string Values(const EffectCheck& effect) {
  std::string text;
  for (Eigen::Index i = 0; i < effect.estimate.size(); ++i) {
    text +=
        fmt::format("{}{:.4g} +- {:.2g}", i > 0 ? ", " : "", effect.estimate[i], effect.sigma[i]);
  }
  return text + " " + effect.unit;
}

std::string Describe(const EffectCheck& effect, bool with_boresight) {
  std::string text =
      fmt::format("the data ask for {} of {} ({})", effect.name, Values(effect), P(effect.p_value));
  const Eigen::Vector3d mdeg = effect.boresight_rad * kDegPerRad * 1e3;
  text += with_boresight ? fmt::format(", which moves the boresight by {:.3g}, {:.3g}, {:.3g} mdeg",
                                       mdeg.x(), mdeg.y(), mdeg.z())
                         : std::string(", which moves the trajectory");
  text += fmt::format(" ({:.1f} sigma)", effect.damage);
  if (!effect.inseparable_from.empty()) {
    text += fmt::format("; {} would explain it nearly as well",
                        fmt::join(effect.inseparable_from, " or "));
  }
  return text + ": " + effect.remedy;
}

bool StartsWith(const std::string& text, const char* prefix) { return text.rfind(prefix, 0) == 0; }

/// What would state the noise of a group larger.
std::string LargerNoise(const std::string& group) {
  if (StartsWith(group, "lidar p2p")) return "lidar.sigma_p_m is too small";
  if (StartsWith(group, "gnss error")) return "the sigmas of gnss.processes are too small";
  if (StartsWith(group, "gnss")) return "the sigmas of gnss.file are too small (gnss.sigma_scale)";
  const bool gyro = StartsWith(group, "gyro") || StartsWith(group, "inertial gyro");
  const bool accel = StartsWith(group, "accel") || StartsWith(group, "inertial");
  if (gyro) return "the noise under imu.gyro is too small";
  if (accel) return "the noise under imu.accel is too small";
  return "their noise is too small";
}

/// What may lie behind errors that last.
std::string LastingErrors(const CommonErrorCheck& common) {
  if (StartsWith(common.name, "lidar p2p, over pairs of strips")) {
    return fmt::format(
        "strips {} disagree most; look at the matching of that file, and at the "
        "trajectory there",
        common.worst);
  }
  if (StartsWith(common.group, "lidar p2p")) {
    return "neighbouring pairs are not independent: thin them (lidar.pairs), or look at the "
           "matching";
  }
  if (StartsWith(common.group, "gnss")) {
    return "GNSS errors that last (gnss_correlated_noise): state them under gnss.processes";
  }
  return LargerNoise(common.group) + ", or a process is missing there";
}

class Findings {
 public:
  explicit Findings(ModelCheck* check) : check_(*check) {}

  void Add(Kind kind, bool contradicts, double evidence, std::string text) {
    check_.findings.push_back({kind, contradicts, evidence, std::move(text)});
  }

  void JudgeEffects() {
    for (const EffectCheck& effect : check_.effects) {
      Add(Kind::kEffect, effect.damage > kDamageInSigmas, effect.log_evidence,
          Describe(effect, check_.of_boresight));
    }
  }

  void JudgeGroups() {
    for (const GroupCheck& group : check_.groups) {
      if (group.p_value > kFamilyLevel || group.variance_ratio < 1.0) continue;
      const bool contradicts = group.ratio_beside_effects > kLargestVarianceRatio;
      Add(Kind::kVariance, contradicts, 0.0,
          fmt::format("the residuals of {} have {:.2f} times the variance that their stated noise "
                      "allows ({}){}: {}, or something is not modelled",
                      group.name, group.variance_ratio, P(group.p_value),
                      group.worst_standardised != 0.0
                          ? fmt::format(", the worst at t = {:.3f} s", group.worst_t_s)
                          : std::string(),
                      LargerNoise(group.name)));
    }
  }

  void JudgeCommonErrors() {
    for (const CommonErrorCheck& common : check_.common_errors) {
      if (common.p_value > kFamilyLevel || common.explained) continue;
      Add(Kind::kCommonError, common.damage > kDamageInSigmas, common.log_evidence,
          fmt::format("the residuals of {} share errors that the model takes as independent, of "
                      "about {:.2g} of their sigmas ({}), which may move the result by {:.1f} "
                      "sigma: {}",
                      common.name, common.sigma, P(common.p_value), common.damage,
                      LastingErrors(common)));
    }
  }

  void JudgePriors() {
    for (const PriorCheck& prior : check_.priors) {
      if (prior.p_value > kFamilyLevel) continue;
      const std::string key = prior.unknown == "boresight"
                                  ? "lidar.boresight_deg with lidar.boresight_sigma_deg"
                                  : "the sigma of " + prior.unknown + " under estimate";
      Add(Kind::kPrior, true, kCertain,
          fmt::format("the stated prior of {} contradicts all other data by {:.1f} sigma ({}): "
                      "check {}",
                      prior.unknown, std::sqrt(prior.statistic / prior.dof), P(prior.p_value),
                      key));
    }
  }

  void JudgeMounting(const Eigen::Vector3d& angles_rad) {
    const Eigen::Vector3d deg = angles_rad * kDegPerRad;
    if (deg.cwiseAbs().maxCoeff() <= kLargestBoresightDeg) return;
    Add(Kind::kMounting, true, kCertain,
        fmt::format("the boresight came out as {:.1f}, {:.1f}, {:.1f} deg, which no mounting has: "
                    "check lidar.R_sensor_to_body, lidar.boresight_deg and the key body",
                    deg.x(), deg.y(), deg.z()));
  }

  void JudgeAttitude(const FlightNetwork& network) {
    double upside_down = 0.0;
    for (std::size_t k = 0; k < network.nodes.size(); ++k) {
      const Eigen::Quaterniond q_nb = ToNavPoint(network.NodePose(k), network.flight().frame).q_nb;
      if (std::abs(RollPitchHeading(q_nb).x()) > 0.5 * std::numbers::pi) upside_down += 1.0;
    }
    if (upside_down < kUpsideDownShare * static_cast<double>(network.nodes.size())) return;
    Add(Kind::kAttitude, check_.of_boresight, kCertain,
        "the body is upside down for the whole flight: are its axes forward-left-up (body: FLU), "
        "or "
        "does imu.R_imu_to_body miss a turn?");
  }

  void JudgeSigma0(double sigma0) {
    if (sigma0 <= kLargestSigma0) return;
    // Effects that leave most of the misfit are not its cause.
    const bool unexplained = check_.sigma0_beside_effects > 0.5 * sigma0;
    Add(Kind::kSigma0, true, unexplained ? kCertain : 0.0,
        fmt::format("sigma0 is {:.1f}: the residuals are that many times their stated noise; check "
                    "units, axes, lever arms, time tags and the stochastic model",
                    sigma0));
  }

  void JudgePairsLeftOut(long left_out, long pairs) {
    const double share = static_cast<double>(left_out) / std::max(1.0, static_cast<double>(pairs));
    if (share <= kPairsLeftOut) return;
    Add(Kind::kPairsLeftOut, true, 0.0,
        fmt::format("{:.0f} % of the pairs contradict the others and were left out: check the "
                    "matching, and that lidar.p2p belongs to this flight",
                    100.0 * share));
  }

  void JudgeGnssLeftOut(long left_out, long epochs) {
    const double share = static_cast<double>(left_out) / std::max(1.0, static_cast<double>(epochs));
    if (share <= kGnssLeftOut) return;
    Add(Kind::kGnssLeftOut, true, 0.0,
        fmt::format(
            "{:.0f} % of the GNSS epochs contradict all other data and were left out: check "
            "gnss.file, its time tags, sigmas and the lever arm",
            100.0 * share));
  }

  void Sort() {
    std::stable_sort(check_.findings.begin(), check_.findings.end(),
                     [](const Finding& a, const Finding& b) {
                       if (a.contradicts != b.contradicts) return a.contradicts;
                       return a.evidence > b.evidence;
                     });
  }

 private:
  ModelCheck& check_;
};

}  // namespace

void AddFindings(const Adjustment& adjustment, const TrajectoryResult& trajectory,
                 ModelCheck* check) {
  const FlightNetwork& network = *adjustment.network;
  Findings findings(check);
  findings.JudgePriors();
  if (check->of_boresight) findings.JudgeMounting(Log(network.net.Value(network.boresight)));
  findings.JudgeAttitude(network);
  findings.JudgeEffects();
  findings.JudgeCommonErrors();
  findings.JudgeSigma0(trajectory.figures.sigma0);
  findings.JudgePairsLeftOut(adjustment.outliers, static_cast<long>(network.pair_edges.size()));
  findings.JudgeGnssLeftOut(static_cast<long>(adjustment.gnss_rejected.size()),
                            static_cast<long>(network.gnss_edges.size()));
  findings.JudgeGroups();
  for (const std::string& warning : adjustment.warnings) {
    findings.Add(Kind::kTrajectory, true, 0.0, warning);
  }
  findings.Sort();
}

void AddFindings(const GaussHelmertCalibration& calibration, ModelCheck* check) {
  Findings findings(check);
  findings.JudgePriors();
  findings.JudgeMounting(calibration.boresight.angles_rad);
  findings.JudgeEffects();
  findings.JudgeSigma0(calibration.figures.sigma0 / std::sqrt(calibration.scatter.expected_ratio));
  findings.JudgePairsLeftOut(calibration.adjustment.outliers,
                             static_cast<long>(calibration.adjustment.weights.size()));
  findings.JudgeGroups();
  findings.Sort();
}

}  // namespace internal

std::vector<std::string> TextsOf(const ModelCheck& check) {
  std::vector<std::string> texts;
  for (const Finding& finding : check.findings) texts.push_back(finding.text);
  return texts;
}

void Assess(const ModelCheck& check, BoresightResult* boresight) {
  if (check.contradicted()) boresight->verdict = "contradicted";
  std::vector<std::string> reasons = TextsOf(check);
  if (reasons.empty()) return;
  for (const std::string& reason : boresight->reasons) {
    if (std::find(reasons.begin(), reasons.end(), reason) == reasons.end()) {
      reasons.push_back(reason);
    }
  }
  boresight->reasons = std::move(reasons);
}

}  // namespace dn
