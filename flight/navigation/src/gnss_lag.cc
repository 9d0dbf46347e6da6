#include <dn/builder/gnss_factors.h>
#include <dn/fit_rotation.h>
#include <dn/navigation/gnss_lag.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "in_flight_alignment.h"
#include "motion_record.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation_internal::Antenna;
using navigation_internal::MotionRecord;

constexpr double kLongestLagS = 120.0;
constexpr double kLagSpacingS = 0.25;
constexpr int kZeroLagStep = static_cast<int>(kLongestLagS / kLagSpacingS);
constexpr int kLagCount = 2 * kZeroLagStep + 1;
constexpr double kFinestSpacingS = 0.03;
// An adjustment finds shorter lags itself.
constexpr double kShortestLagS = 2.0;
constexpr double kLagWindowS = 30.0;
constexpr double kWindowSpacings = 12.0;
constexpr double kUnevenRatio = 2.0;
// ln of the likelihood ratio of a decisive lag: half the chi-square of 31.8, which has a
// probability of 2e-8.
constexpr double kCertainGain = 15.9;
// Neighbouring second differences share two of three positions, so that they count half.
constexpr double kIndependentShare = 0.5;
// Lags that leave fewer of the windows than this share are not judged.
constexpr double kLeastCovered = 0.5;
// A lag explains the motion only if the variance of the residuals falls by this factor at least.
constexpr double kLeastImprovement = 1.5;
// Misfit at lag 0, in sigmas of the positions, below which no other lag is searched. The misfit of
// a perfect fit is the root of 2, see Comparison::Variance.
constexpr double kGoodFit = 1.6;
// Misfit of a lag, in the same unit, that leaves doubt whether the files belong to one flight.
constexpr double kBadFit = 5.0;
constexpr int kUnknowns = 9;
constexpr double kGyroBiasRadps = 0.01, kAccelBiasMps2 = 0.3, kTiltRad = 1.0;
constexpr double kWeightSigmaMps2 = 0.1;
constexpr double kSmallestSigmaS = 0.05;

/// A second difference of the GNSS positions.
struct Triple {
  double t_s[3];
  double ratio;      // of the second time step to the first
  double square_s2;  // divisor of the second difference
  Vector3d beta_mps2;
};

/// Second differences with a common attitude.
struct Window {
  std::vector<Triple> triples;
  double t0_s() const { return triples.front().t_s[0]; }
  double t1_s() const { return triples.back().t_s[2]; }
  double dof() const { return 3.0 * static_cast<double>(triples.size()) - kUnknowns; }
};

Triple MakeTriple(const LocalFrame& frame, double t_first_s, const Antenna& a, const Antenna& b,
                  const Antenna& c) {
  const double first_s = b.t_s - a.t_s, second_s = c.t_s - b.t_s, r = second_s / first_s;
  const double square_s2 = 0.5 * second_s * (first_s + second_s);
  const auto turn = [&](const Antenna& at) {
    return Exp(Vector3d(frame.w_ie_m() * (at.t_s - t_first_s)));
  };
  const auto place = [&](const Antenna& at) {
    return Vector3d(turn(at) * (frame.r0_m() + at.p_m));
  };
  const Vector3d difference = place(c) - (1.0 + r) * place(b) + r * place(a);
  return {{a.t_s, b.t_s, c.t_s},
          r,
          square_s2,
          difference / square_s2 - turn(b) * frame.Gravitation(b.p_m)};
}

std::vector<Antenna> SpacedTrack(const Flight& flight, double spacing_s) {
  std::vector<Antenna> track;
  for (const Antenna& at : navigation_internal::AntennaTrack(flight, {-1e300, 1e300})) {
    if (track.empty() || at.t_s - track.back().t_s >= spacing_s - 1e-3) track.push_back(at);
  }
  return track;
}

std::vector<Window> MakeWindows(const Flight& flight, double spacing_s) {
  const std::vector<Antenna> track = SpacedTrack(flight, spacing_s);
  const double length_s = std::max(kLagWindowS, kWindowSpacings * spacing_s);
  std::vector<Window> windows(1);
  for (std::size_t k = 2; k < track.size(); ++k) {
    const Triple triple =
        MakeTriple(flight.frame, track.front().t_s, track[k - 2], track[k - 1], track[k]);
    if (triple.ratio > kUnevenRatio || triple.ratio < 1.0 / kUnevenRatio) continue;
    std::vector<Triple>& now = windows.back().triples;
    if (!now.empty() && triple.t_s[0] > now.front().t_s[0] + length_s) windows.emplace_back();
    windows.back().triples.push_back(triple);
  }
  std::erase_if(windows, [](const Window& window) { return window.dof() < kUnknowns; });
  return windows;
}

/// The inertial counterpart of a second difference.
struct InertialTriple {
  Vector3d alpha_mps2;
  Matrix3d R_rb;    // attitude at the middle
  Matrix3d sum_rb;  // integral of the attitude up to the middle
};

/// Compares second differences of positions with those of the inertial data.
class Comparison {
 public:
  explicit Comparison(const Flight& flight)
      : flight_(flight),
        record_(*flight.imu),
        spacing_s_(navigation_internal::AlignmentSpacing(flight)),
        windows_(MakeWindows(flight, spacing_s_)) {}

  const std::vector<Window>& windows() const { return windows_; }
  double spacing_s() const { return spacing_s_; }

  /// Returns the noise of a second difference, m/s^2.
  double Noise() const {
    return std::sqrt(6.0) * TypicalGnssSigma(flight_) / (spacing_s_ * spacing_s_);
  }

  bool Covers(const Window& window, double lag_s) const {
    const double t0_s = window.t0_s() - lag_s, t1_s = window.t1_s() - lag_s;
    return t0_s >= record_.t_begin_s() && t1_s <= record_.t_end_s() &&
           !HasGap(*flight_.imu, t0_s, t1_s);
  }

  /// Returns the variance of the residuals of a window with the noise of the positions added,
  /// (m/s^2)^2. A window that fits by chance then does not decide.
  double Variance(const Window& window, double lag_s) const {
    std::vector<InertialTriple> inertial;
    for (const Triple& triple : window.triples) inertial.push_back(At(triple, lag_s));
    return SquaresLeft(window, inertial) / window.dof() + Noise() * Noise();
  }

 private:
  InertialTriple At(const Triple& triple, double lag_s) const {
    MotionRecord::State at[3];
    for (int k = 0; k < 3; ++k) at[k] = record_.At(triple.t_s[k] - lag_s);
    const auto antenna = [&](int k) {
      return Vector3d(at[k].p_r + at[k].R_rb * flight_.config.gnss->lever_arm_b_m);
    };
    const double r = triple.ratio;
    return {(antenna(2) - (1.0 + r) * antenna(1) + r * antenna(0)) / triple.square_s2, at[1].R_rb,
            at[1].sum_rb};
  }

  static Matrix3d Attitude(const Window& window, const std::vector<InertialTriple>& inertial) {
    Matrix3d B = Matrix3d::Zero();
    for (std::size_t k = 0; k < inertial.size(); ++k) {
      B += window.triples[k].beta_mps2 * inertial[k].alpha_mps2.transpose();
    }
    return FitRotation(B).R;
  }

  static Eigen::Matrix<double, kUnknowns, kUnknowns> Priors() {
    const auto weight = [](double sigma) {
      return Vector3d::Constant(std::pow(kWeightSigmaMps2 / sigma, 2));
    };
    Eigen::Matrix<double, kUnknowns, 1> weights;
    weights << weight(kTiltRad), weight(kGyroBiasRadps), weight(kAccelBiasMps2);
    return weights.asDiagonal();
  }

  static double SquaresLeft(const Window& window, const std::vector<InertialTriple>& inertial) {
    const Matrix3d R = Attitude(window, inertial);
    const Matrix3d& sum_middle = inertial[inertial.size() / 2].sum_rb;
    Eigen::Matrix<double, kUnknowns, kUnknowns> N = Priors();
    Eigen::Matrix<double, kUnknowns, 1> g = Eigen::Matrix<double, kUnknowns, 1>::Zero();
    double squares = 0.0;
    for (std::size_t k = 0; k < inertial.size(); ++k) {
      const InertialTriple& one = inertial[k];
      const Vector3d left = R.transpose() * window.triples[k].beta_mps2 - one.alpha_mps2;
      const Matrix3d turn = -Skew(one.alpha_mps2);
      Eigen::Matrix<double, 3, kUnknowns> J;
      J << turn, turn * (one.sum_rb - sum_middle), one.R_rb;
      N += J.transpose() * J;
      g += J.transpose() * left;
      squares += left.squaredNorm();
    }
    return squares - g.dot(N.ldlt().solve(g));
  }

  const Flight& flight_;
  MotionRecord record_;
  double spacing_s_;
  std::vector<Window> windows_;
};

double LagAt(int step) { return (step - kZeroLagStep) * kLagSpacingS; }

/// Likelihood of lags against lag 0.
class LagLikelihood {
 public:
  explicit LagLikelihood(const Comparison& comparison) : comparison_(comparison) {
    for (const Window& window : comparison.windows()) {
      if (!comparison.Covers(window, 0.0)) continue;
      at_zero_.push_back({&window, Variance(window, 0.0)});
      dof_ += window.dof();
    }
  }

  /// Returns the rms of the residuals at a lag over the noise of the positions; 0 without windows.
  double MisfitAt(double lag_s) const {
    double squares = 0.0, dof = 0.0;
    for (const auto& [window, variance] : at_zero_) {
      if (!comparison_.Covers(*window, lag_s)) continue;
      squares += Variance(*window, lag_s) * window->dof();
      dof += window->dof();
    }
    return dof > 0.0 ? std::sqrt(squares / dof) / comparison_.Noise() : 0.0;
  }

  struct Gain {
    double gain = 0.0;  ///< ln of the likelihood ratio of a lag and lag 0
    /// The same for all windows, if those that the lag does not cover are like the others.
    double whole_gain = -1e300;
    double improvement = 1.0;  ///< geometric mean of the ratios of variances
  };

  Gain At(double lag_s) const {
    double sum = 0.0, dof = 0.0;
    for (const auto& [window, variance] : at_zero_) {
      if (!comparison_.Covers(*window, lag_s)) continue;
      sum += window->dof() * std::log(variance / Variance(*window, lag_s));
      dof += window->dof();
    }
    if (dof < kLeastCovered * dof_) return {};
    const double gain = 0.5 * kIndependentShare * sum;
    return {gain, gain * dof_ / dof, std::exp(sum / dof)};
  }

 private:
  double Variance(const Window& window, double lag_s) const {
    return comparison_.Variance(window, lag_s);
  }

  struct Zero {
    const Window* window;
    double variance;
  };

  const Comparison& comparison_;
  std::vector<Zero> at_zero_;
  double dof_ = 0.0;
};

/// Likelihoods of lags in equal steps.
class LagSearch {
 public:
  LagSearch(const LagLikelihood& likelihood, double spacing_s)
      : likelihood_(likelihood), rival_distance_s_(std::max(kShortestLagS, spacing_s)) {
    for (int step = 0; step < kLagCount; ++step) gains_.push_back(likelihood.At(LagAt(step)));
  }

  int Best() const {
    return BestIf([](double) { return true; });
  }

  /// Returns the best of the lags that an adjustment finds.
  int BestShort() const {
    return BestIf([](double lag_s) { return std::abs(lag_s) < kShortestLagS; });
  }

  bool IsDecisive(int step) const {
    const LagLikelihood::Gain& gain = gains_[Index(step)];
    return gain.gain > kCertainGain && gain.improvement > kLeastImprovement;
  }

  bool IsDecisivelyBetter(int step, int other) const {
    return Gain(step) - Gain(other) > kCertainGain;
  }

  /// Returns true if a lag is decisively better than all that are not its neighbours.
  bool IsUnique(int step) const {
    const int rival =
        BestIf([&](double lag_s) { return std::abs(lag_s - LagAt(step)) >= rival_distance_s_; });
    return IsDecisivelyBetter(step, rival);
  }

  /// Returns the lag of a step, refined by parabolas through its neighbours on finer scales.
  GnssLag Refined(int step) const {
    GnssLag found{LagAt(step), kSmallestSigmaS, gains_[Index(step)].gain, IsUnique(step)};
    for (double spacing_s = kLagSpacingS; spacing_s > kFinestSpacingS; spacing_s *= 0.5) {
      Refine(spacing_s, &found);
    }
    return found;
  }

 private:
  static std::size_t Index(int step) { return static_cast<std::size_t>(step); }
  double Gain(int step) const { return gains_[Index(step)].whole_gain; }

  template <typename Condition>
  int BestIf(const Condition& condition) const {
    int best = -1;
    for (int step = 0; step < kLagCount; ++step) {
      if (condition(LagAt(step)) && (best < 0 || Gain(step) > Gain(best))) best = step;
    }
    return best;
  }

  void Refine(double spacing_s, GnssLag* found) const {
    const double before = likelihood_.At(found->lag_s - spacing_s).gain;
    const double here = likelihood_.At(found->lag_s).gain;
    const double after = likelihood_.At(found->lag_s + spacing_s).gain;
    const double curvature = (2.0 * here - before - after) / (spacing_s * spacing_s);
    if (!(curvature > 0.0)) return;
    const double move_s = 0.5 * (after - before) / (spacing_s * curvature);
    found->lag_s += std::clamp(move_s, -spacing_s, spacing_s);
    found->sigma_s = std::max(kSmallestSigmaS, 1.0 / std::sqrt(curvature));
  }

  const LagLikelihood& likelihood_;
  double rival_distance_s_;
  std::vector<LagLikelihood::Gain> gains_;
};

bool HasMotion(const Flight& flight) {
  return flight.imu && flight.imu->samples.size() > 1 && flight.gnss &&
         flight.gnss->epochs.size() > 2;
}

}  // namespace

std::optional<GnssLag> FindGnssLag(const Flight& flight) {
  if (!HasMotion(flight)) return std::nullopt;
  const Comparison comparison(flight);
  const LagLikelihood likelihood(comparison);
  if (likelihood.MisfitAt(0.0) <= kGoodFit) return std::nullopt;
  const LagSearch search(likelihood, comparison.spacing_s());
  const int best = search.Best();
  if (!search.IsDecisive(best)) return std::nullopt;
  GnssLag found = search.Refined(best);
  found.certain = found.certain && likelihood.MisfitAt(found.lag_s) < kBadFit;
  const bool is_short = std::abs(found.lag_s) - 3.0 * found.sigma_s < kShortestLagS;
  return is_short ? std::nullopt : std::optional(found);
}

bool GnssTagsFit(const Flight& flight) {
  if (!HasMotion(flight)) return true;
  const Comparison comparison(flight);
  const LagLikelihood likelihood(comparison);
  if (likelihood.MisfitAt(0.0) <= kGoodFit) return true;
  const LagSearch search(likelihood, comparison.spacing_s());
  const int best = search.BestShort();
  return search.IsUnique(best) && !search.IsDecisivelyBetter(search.Best(), best);
}

}  // namespace dn
