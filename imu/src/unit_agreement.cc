#include <dn/distributions.h>
#include <dn/fit_rotation.h>
#include <dn/imu/unit_agreement.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rates are compared as means over bins: of this length, or of a row if rows are longer.
constexpr double kLeastBinS = 0.1;
constexpr double kFewestBins = 200.0;
// Correlation of the magnitudes of the rates of one motion; that of a rival offset is smaller.
constexpr double kSameMotion = 0.5, kLeastLead = 0.15;
constexpr double kRivalDistanceBins = 20.0;
constexpr int kIterations = 20, kParts = 8;
constexpr double kConvergedS = 1e-7;
// The least of the singular values of the turns over the largest.
constexpr double kLeastTurn = 0.02;

/// Integral of the rates over time.
class SummedRates {
 public:
  SummedRates(const ImuData& imu, double bin_s) : bin_s_(bin_s) {
    t_s_.push_back(imu.t_begin_s());
    sum_rad_.push_back(Vector3d::Zero());
    for (const ImuSample& sample : imu.samples) {
      sum_rad_.push_back(sum_rad_.back() + (sample.t_s - t_s_.back()) * sample.w_ib_b_radps);
      t_s_.push_back(sample.t_s);
    }
  }

  double begin_s() const { return t_s_.front(); }
  double end_s() const { return t_s_.back(); }
  double bin_s() const { return bin_s_; }

  /// Returns the mean rate of the bin around a time.
  Vector3d Mean(double t_s) const {
    return (At(t_s + 0.5 * bin_s_) - At(t_s - 0.5 * bin_s_)) / bin_s_;
  }

  /// Returns the middles of the bins from one time to another.
  std::vector<double> Bins(double begin_s, double end_s) const {
    std::vector<double> bins_s;
    for (double t_s = begin_s + 0.5 * bin_s_; t_s + 0.5 * bin_s_ <= end_s; t_s += bin_s_) {
      bins_s.push_back(t_s);
    }
    return bins_s;
  }

 private:
  Vector3d At(double t_s) const {
    auto after = std::upper_bound(t_s_.begin() + 1, t_s_.end() - 1, t_s);
    const auto k = static_cast<std::size_t>(after - t_s_.begin());
    const double share = (t_s - t_s_[k - 1]) / (t_s_[k] - t_s_[k - 1]);
    return sum_rad_[k - 1] + share * (sum_rad_[k] - sum_rad_[k - 1]);
  }

  double bin_s_;
  std::vector<double> t_s_;
  std::vector<Vector3d> sum_rad_;
};

std::vector<double> Magnitudes(const SummedRates& rates) {
  std::vector<double> magnitudes;
  for (const double t_s : rates.Bins(rates.begin_s(), rates.end_s())) {
    magnitudes.push_back(rates.Mean(t_s).norm());
  }
  return magnitudes;
}

/// Returns the correlation of x[k] and y[k + shift]; 0 if the overlap is too short.
double Correlation(const std::vector<double>& x, const std::vector<double>& y, long shift) {
  const long first = std::max(0L, -shift);
  const long past =
      std::min<long>(static_cast<long>(x.size()), static_cast<long>(y.size()) - shift);
  const auto n = static_cast<double>(past - first);
  if (n < kFewestBins) return 0.0;
  const Eigen::Map<const Eigen::ArrayXd> u(x.data() + first, past - first);
  const Eigen::Map<const Eigen::ArrayXd> v(y.data() + first + shift, past - first);
  const double mean_u = u.mean(), mean_v = v.mean();
  const double uv = (u * v).mean() - mean_u * mean_v;
  const double uu = u.square().mean() - mean_u * mean_u, vv = v.square().mean() - mean_v * mean_v;
  return uu > 0.0 && vv > 0.0 ? uv / std::sqrt(uu * vv) : 0.0;
}

/// Returns the offset of the tags at which the magnitudes agree; nullopt if none is certain.
std::optional<double> CoarseOffset(const SummedRates& a, const SummedRates& b) {
  const std::vector<double> x = Magnitudes(a), y = Magnitudes(b);
  const long first = -static_cast<long>(x.size()), last = static_cast<long>(y.size());
  std::vector<double> correlations;
  for (long shift = first; shift <= last; ++shift) correlations.push_back(Correlation(x, y, shift));
  const auto best = std::max_element(correlations.begin(), correlations.end());
  double rival = 0.0;
  for (auto it = correlations.begin(); it != correlations.end(); ++it) {
    const bool far = std::abs(static_cast<double>(it - best)) > kRivalDistanceBins;
    if (far) rival = std::max(rival, *it);
  }
  if (*best < kSameMotion || *best - rival < kLeastLead) return std::nullopt;
  const auto shift = static_cast<double>(first + (best - correlations.begin()));
  return b.begin_s() - a.begin_s() + shift * a.bin_s();
}

/// Parameters of the relation: offset, drift, a small rotation and the bias.
using Parameters = Eigen::Matrix<double, 8, 1>;
using Normals = Eigen::Matrix<double, 8, 8>;

struct Relation {
  double offset_s = 0.0, drift = 0.0;
  Matrix3d R_ba = Matrix3d::Identity();
  Vector3d bias_radps = Vector3d::Zero();
};

/// Rates of both units in the bins of a span.
class Span {
 public:
  Span(const SummedRates& a, const SummedRates& b, double first_s, std::vector<double> bins_s)
      : a_(a), b_(b), first_s_(first_s), bins_s_(std::move(bins_s)) {}

  std::size_t size() const { return bins_s_.size(); }

  /// Returns the rotation that fits the rates best, without their means; its singular values tell
  /// whether the turns determine it.
  Matrix3d Rotation(double offset_s, bool* determined) const {
    Matrix3d B = Matrix3d::Zero();
    Vector3d mean_a = Vector3d::Zero(), mean_b = mean_a;
    for (const double t_s : bins_s_) {
      mean_a += a_.Mean(t_s) / static_cast<double>(size());
      mean_b += b_.Mean(t_s + offset_s) / static_cast<double>(size());
    }
    for (const double t_s : bins_s_) {
      B += (b_.Mean(t_s + offset_s) - mean_b) * (a_.Mean(t_s) - mean_a).transpose();
    }
    const RotationFit fit = FitRotation(B);
    *determined = fit.singular_values[1] > kLeastTurn * fit.singular_values[0];
    return fit.R;
  }

  Vector3d Residual(const Relation& relation, double t_s) const {
    return b_.Mean(SecondTag(relation, t_s)) - relation.R_ba * a_.Mean(t_s) - relation.bias_radps;
  }

  /// Adds the normal equations of one bin. The slope is that of a: noise of b in slope and residual
  /// would pull the offset to where bins lie between rows, since two rows average it there.
  void Accumulate(const Relation& relation, double t_s, Normals* N, Parameters* g) const {
    const double half_s = 0.5 * a_.bin_s();
    const Vector3d slope =
        relation.R_ba * (a_.Mean(t_s + half_s) - a_.Mean(t_s - half_s)) / a_.bin_s();
    Eigen::Matrix<double, 3, 8> J;
    J << slope, (t_s - first_s_) * slope, Skew(Vector3d(relation.R_ba * a_.Mean(t_s))),
        -Matrix3d::Identity();
    *N += J.transpose() * J;
    *g -= J.transpose() * Residual(relation, t_s);
  }

  const std::vector<double>& bins_s() const { return bins_s_; }

 private:
  double SecondTag(const Relation& relation, double t_s) const {
    return t_s + relation.offset_s + relation.drift * (t_s - first_s_);
  }

  const SummedRates& a_;
  const SummedRates& b_;
  double first_s_;
  std::vector<double> bins_s_;
};

/// Returns the rms of the rates in a span without their mean, per axis.
double Motion(const SummedRates& rates, const std::vector<double>& bins_s) {
  const auto n = static_cast<double>(bins_s.size());
  Vector3d sum = Vector3d::Zero();
  double square = 0.0;
  for (const double t_s : bins_s) {
    const Vector3d w = rates.Mean(t_s);
    sum += w;
    square += w.squaredNorm();
  }
  return std::sqrt((square / n - (sum / n).squaredNorm()) / 3.0);
}

struct UnitSolution {
  Relation relation;
  Normals covariance = Normals::Zero();
  double noise_radps = 0.0;
};

/// Noise of the residuals of a solution, and how much their correlation enlarges variances.
struct Noise {
  double variance = 0.0, inflation = 1.0;
};

Noise ResidualNoise(const Span& span, const Relation& relation) {
  double square = 0.0, product = 0.0;
  Vector3d before = Vector3d::Zero();
  for (const double t_s : span.bins_s()) {
    const Vector3d r = span.Residual(relation, t_s);
    square += r.squaredNorm();
    product += r.dot(before);
    before = r;
  }
  const double lag1 = std::clamp(product / square, 0.0, 0.9);
  return {square / (3.0 * static_cast<double>(span.size()) - 8.0), (1.0 + lag1) / (1.0 - lag1)};
}

/// Leaves the drift out of normal equations.
void HoldDrift(Normals* N, Parameters* g) {
  N->row(1).setZero();
  N->col(1).setZero();
  (*N)(1, 1) = 1.0;
  (*g)[1] = 0.0;
}

/// Solves the least squares, with the drift held or free.
UnitSolution SolveUnits(const Span& span, Relation start, bool with_drift) {
  UnitSolution solution{std::move(start)};
  Relation& now = solution.relation;
  Normals N;
  for (int k = 0; k < kIterations; ++k) {
    N.setZero();
    Parameters g = Parameters::Zero();
    for (const double t_s : span.bins_s()) span.Accumulate(now, t_s, &N, &g);
    if (!with_drift) HoldDrift(&N, &g);
    const Parameters step = N.ldlt().solve(g);
    now.offset_s += step[0];
    now.drift += step[1];
    now.R_ba = Exp(Vector3d(step.segment<3>(2))).toRotationMatrix() * now.R_ba;
    now.bias_radps += step.tail<3>();
    if (std::abs(step[0]) < kConvergedS && step.segment<3>(2).norm() < kConvergedS) break;
  }
  const Noise noise = ResidualNoise(span, now);
  solution.covariance = noise.variance * noise.inflation * N.inverse();
  solution.noise_radps = std::sqrt(noise.variance);
  return solution;
}

/// Moves the reference time of the drift.
Relation AtLaterReference(Relation relation, double by_s) {
  relation.offset_s += relation.drift * by_s;
  return relation;
}

/// Returns the squared differences of offset and rotation of a part from the whole over their
/// covariance.
double SquaredDifference(const UnitSolution& part, const Relation& whole) {
  Eigen::Vector4d d;
  d[0] = part.relation.offset_s - whole.offset_s;
  d.tail<3>() = Log(Eigen::Quaterniond(Matrix3d(part.relation.R_ba * whole.R_ba.transpose())));
  const int kept[] = {0, 2, 3, 4};
  return d.dot(Eigen::Matrix4d(part.covariance(kept, kept)).ldlt().solve(d));
}

/// Two units and the span that both cover.
class Pair {
 public:
  Pair(const ImuData& a, const ImuData& b, double bin_s)
      : a_(a, bin_s), b_(b, bin_s), coarse_s_(CoarseOffset(a_, b_)) {
    if (!coarse_s_) return;
    first_s_ = std::max(a_.begin_s(), b_.begin_s() - *coarse_s_) + MarginS();
    last_s_ = std::min(a_.end_s(), b_.end_s() - *coarse_s_) - MarginS();
  }

  bool has_span() const { return coarse_s_ && last_s_ - first_s_ > kFewestBins * a_.bin_s(); }
  double first_s() const { return first_s_; }
  double last_s() const { return last_s_; }
  double motion_radps() const { return Motion(a_, a_.Bins(first_s_, last_s_)); }

  /// Returns nullopt if the turns do not determine the rotation.
  std::optional<UnitSolution> Whole() const {
    const Span span(a_, b_, first_s_, a_.Bins(first_s_, last_s_));
    bool determined = false;
    Relation start{*coarse_s_};
    start.R_ba = span.Rotation(*coarse_s_, &determined);
    return determined ? std::optional(SolveUnits(span, start, true)) : std::nullopt;
  }

  /// Returns the sum of the squared differences of all parts from the whole.
  double PartDifferences(const Relation& whole) const {
    const double length_s = (last_s_ - first_s_) / kParts;
    double sum = 0.0;
    for (int k = 0; k < kParts; ++k) {
      const double begin_s = first_s_ + k * length_s, middle_s = begin_s + 0.5 * length_s;
      const Span part(a_, b_, middle_s, a_.Bins(begin_s, begin_s + length_s));
      const Relation here = AtLaterReference(whole, middle_s - first_s_);
      sum += SquaredDifference(SolveUnits(part, here, false), here);
    }
    return sum;
  }

 private:
  // The fine offset and the drift stay inside the records.
  double MarginS() const { return kMarginBins * a_.bin_s(); }

  static constexpr double kMarginBins = 10.0;

  SummedRates a_, b_;
  std::optional<double> coarse_s_;
  double first_s_ = 0.0, last_s_ = 0.0;
};

}  // namespace

std::optional<UnitAgreement> CompareUnits(const ImuData& a, const ImuData& b) {
  const Pair pair(a, b, std::max({kLeastBinS, a.nominal_dt_s, b.nominal_dt_s}));
  if (!pair.has_span()) return std::nullopt;
  const std::optional<UnitSolution> whole = pair.Whole();
  if (!whole) return std::nullopt;
  // Offset and rotation of each part, less offset, drift and rotation of the whole.
  constexpr int kDof = 4 * kParts - 5;
  const double sum = pair.PartDifferences(whole->relation);
  const double ratio = sum / kDof;
  const Parameters sigma =
      std::sqrt(std::max(1.0, ratio)) * whole->covariance.diagonal().cwiseSqrt();
  return UnitAgreement{.offset_s = whole->relation.offset_s,
                       .sigma_offset_s = sigma[0],
                       .drift = whole->relation.drift,
                       .sigma_drift = sigma[1],
                       .q_ba = Eigen::Quaterniond(whole->relation.R_ba),
                       .sigma_rotation_rad = sigma.segment<3>(2),
                       .first_s = pair.first_s(),
                       .last_s = pair.last_s(),
                       .noise_radps = whole->noise_radps,
                       .motion_radps = pair.motion_radps(),
                       .variance_ratio = ratio,
                       .p_value = ChiSquareTail(sum, kDof)};
}

}  // namespace dn
