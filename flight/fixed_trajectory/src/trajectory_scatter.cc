#include <dn/error.h>
#include <dn/fixed_trajectory/trajectory_scatter.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "node_sums.h"
#include "scatter_of_sums.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

using fixed_trajectory_internal::AdjustmentErrorCovariance;
using fixed_trajectory_internal::ErrorModel;
using fixed_trajectory_internal::ErrorProcess;
using fixed_trajectory_internal::NodeSums;
using fixed_trajectory_internal::TimeNodes;

constexpr double kLongestTau_s = 1000.0;  // longest correlation time that is reported
// Correlation times for errors of unknown origin.
constexpr double kAnyTaus_s[] = {3.0, 10.0, 30.0, 100.0, 300.0, 1000.0};
// Error processes of a smoother. GNSS corrects positions within seconds to tens of seconds. Gyros
// carry attitude errors over tens to hundreds of seconds. The tilt error stays fixed in the
// navigation frame when the aircraft turns, unless the turn makes it observable.
constexpr double kPositionTaus_s[] = {5.0, 25.0};
constexpr ErrorProcess kAttitudeErrors[] = {{ErrorProcess::Kind::kGaussMarkov, 30.0},
                                            {ErrorProcess::Kind::kGaussMarkov, 100.0},
                                            {ErrorProcess::Kind::kGaussMarkov, 300.0},
                                            {ErrorProcess::Kind::kPerStrip}};
/// Share of the attitude variance that is constant over the flight, with its prior weight.
/// Jeffreys' prior of an unknown proportion is 1 / (pi sqrt(x (1 - x))); these are the nodes and
/// weights of its Gauss-Lobatto (Chebyshev) quadrature.
struct ConstantShare {
  double share, weight;
};
constexpr ConstantShare kConstantShares[] = {{0.0, 0.25}, {0.5, 0.5}, {1.0, 0.25}};
constexpr double kLog2Ratios[] = {-3.0, -1.5, 0.0, 1.5, 3.0};  // grid of log2(s_p / s_a)
// Standard deviation, in octaves, of the log-normal prior of the scale of the stated sigmas. It is
// a factor of 1.3 for a smoother and 1.6 for a data sheet. The mean of the variance equals the
// stated variance.
constexpr double kSmootherOctaves = 0.4;
constexpr double kDataSheetOctaves = 0.7;
// Grid of (s / s0)^2 in octaves, from a negligible error to 32 times the stated sigma.
constexpr int kFirstRhoOctave = -16;
constexpr int kLastRhoOctave = 10;
constexpr int kRhoStepsPerOctave = 4;

std::vector<double> Epochs(const GaussHelmertProblem& problem, const std::vector<double>& weights) {
  std::vector<double> t_s;
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    if (weights[k] == 0.0) continue;
    t_s.push_back(problem.pairs[k].i.t_s);
    t_s.push_back(problem.pairs[k].j.t_s);
  }
  return t_s;
}

/// log det(I + rho T) and c^T (I/rho + T)^-1 c of a symmetric tridiagonal T >= 0.
struct TridiagonalFigures {
  double log_det = 0.0;
  double explained = 0.0;
};

TridiagonalFigures Evaluate(const VectorXd& diagonal, const VectorXd& sub, const VectorXd& c,
                            double rho) {
  TridiagonalFigures out;
  double pivot = 0.0, forward = 0.0;  // L D L^T and its forward substitution
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    const double off = i == 0 ? 0.0 : rho * sub[i - 1];
    const double next = 1.0 + rho * diagonal[i] - (i == 0 ? 0.0 : off * off / pivot);
    forward = c[i] - (i == 0 ? 0.0 : off / pivot * forward);
    // Like the eigenvalues of I + rho T, the pivots are >= 1 except for rounding.
    pivot = std::max(next, 1.0);
    out.log_det += std::log(pivot);
    out.explained += rho * forward * forward / pivot;
  }
  return out;
}

/// One point of the grid over (s_p, s_a, share, processes).
struct GridPoint {
  double log_prior = 0.0;
  double log_posterior = 0.0;
  double s_p = 0.0, s_a = 0.0;  ///< sigma of the positions and attitudes / stated sigma
  double constant_share = 0.0;  ///< share of the attitude variance that is constant
  std::size_t effect = 0;
};

/// Effect of errors of unit size on the estimate.
struct ErrorEffect {
  MatrixXd position;  ///< covariance of the unknowns from position errors
  MatrixXd attitude;
  double tau_s = 0.0;  ///< correlation time of the attitude errors; 0 if they are constant
  /// Contributions of the errors to the expected sum of squares of the misclosures, tr(H_P C), and
  /// tr((H_P C)^2) of both errors together for its variance.
  double position_chi2 = 0.0, attitude_chi2 = 0.0, square = 0.0;
};

/// Information of the misclosures about the varying errors of unit size, in tridiagonal form.
struct Information {
  VectorXd diagonal, sub, c;
};

/// Relation between the common scale s of an Information and the sizes of the errors, s_p =
/// position s and s_a = attitude s. It includes the constant share of the attitude variance.
struct Sizes {
  double position = 1.0, attitude = 1.0, constant_share = 0.0;
  double log_weight = 0.0;
};

double CorrelationTime(const ErrorModel& model) {
  return model.attitude.kind == ErrorProcess::Kind::kGaussMarkov ? model.attitude.tau_s
                                                                 : kLongestTau_s;
}

std::vector<ErrorModel> SmootherModels() {
  std::vector<ErrorModel> models;
  for (const double tau_s : kPositionTaus_s) {
    const ErrorProcess position{ErrorProcess::Kind::kGaussMarkov, tau_s};
    for (const ErrorProcess& attitude : kAttitudeErrors)
      models.push_back({position, attitude, true});
  }
  return models;
}

std::vector<ErrorModel> DataSheetModels() {
  const ErrorProcess position{ErrorProcess::Kind::kGaussMarkov, kPositionTaus_s[1]};
  std::vector<ErrorModel> models;
  for (const ErrorProcess& attitude : kAttitudeErrors) models.push_back({position, attitude, true});
  for (const double tau_s : kAnyTaus_s) {
    const ErrorProcess process{ErrorProcess::Kind::kGaussMarkov, tau_s};
    models.push_back({process, process, false});
  }
  return models;
}

double Squared(double x) { return x * x; }

class ScatterEstimator {
 public:
  ScatterEstimator(double redundancy, const TimeNodes& nodes, const NodeSums& sums,
                   SigmaSource sigma_source)
      : by_smoother_(sigma_source == SigmaSource::kSmoother),
        octaves_(by_smoother_ ? kSmootherOctaves : kDataSheetOctaves),
        nu_(redundancy),
        nodes_(nodes),
        heading_rad_(sums.heading_rad),
        effect_(sums.N_e * sums.N.inverse()),
        H_P_(sums.H - effect_ * sums.N_e.transpose()),
        b_(sums.b - effect_ * sums.g),
        chi2_(sums.chi2 - sums.g.dot(sums.N.llt().solve(sums.g))) {}

  AdjustmentErrorCovariance Run() {
    for (const ErrorModel& model : by_smoother_ ? SmootherModels() : DataSheetModels()) {
      AddVarying(model);
    }
    for (const double tau_s : kPositionTaus_s) {
      AddConstantAttitude({ErrorProcess::Kind::kGaussMarkov, tau_s});
    }
    return Average();
  }

  /// Runs the estimation for errors with the covariance C times an unknown factor.
  AdjustmentErrorCovariance Run(const MatrixXd& C) {
    const VectorXd sigma = C.diagonal().cwiseSqrt();
    const MatrixXd R = sigma.cwiseInverse().asDiagonal() * C * sigma.cwiseInverse().asDiagonal();
    const MatrixXd L = sigma.asDiagonal() * Root(R);
    const MatrixXd M = L.transpose() * (H_P_ * L);
    effects_.push_back({NoEffect(), effect_.transpose() * C * effect_, 0.0, 0.0,
                        H_P_.cwiseProduct(C).sum(), M.squaredNorm()});
    AddPoints(Reduce(M, L.transpose() * b_), {{}});
    return Average();
  }

 private:
  const MatrixXd& Unit(const ErrorProcess& process) {
    for (const auto& [known, K] : covariances_) {
      if (known == process) return K;
    }
    covariances_.emplace_back(process, nodes_.Covariance(process));
    return covariances_.back().second;
  }

  // Returns the covariance of the varying part of roll, pitch and heading at the nodes. An error
  // that is constant over the flight does not affect the misclosures.
  MatrixXd AttitudeCovariance(const ErrorModel& model) {
    const int T = nodes_.size();
    MatrixXd C = MatrixXd::Zero(3 * T, 3 * T);
    const MatrixXd& K = Unit(model.attitude);
    for (int c = 0; c < 3; ++c) C.block(c * T, c * T, T, T) = K;
    if (!model.tilt_in_nav) return C;
    for (int n = 0; n < T; ++n) {
      for (int m = 0; m < T; ++m) {
        const double turn = heading_rad_[n] - heading_rad_[m];
        C(n, m) = C(T + n, T + m) = std::cos(turn) * K(n, m);
        C(n, T + m) = std::sin(turn) * K(n, m);
        C(T + n, m) = -C(n, T + m);
      }
    }
    return C;
  }

  // Returns the lower triangular L with L L^T = C.
  static MatrixXd Root(const MatrixXd& C) {
    constexpr double kRounding = 1e-7;  // keeps C positive definite despite rounding
    const MatrixXd I = MatrixXd::Identity(C.rows(), C.cols());
    return Eigen::LLT<MatrixXd>(C + kRounding * I).matrixL();
  }

  void AddVarying(const ErrorModel& model) {
    const int T = nodes_.size();
    const MatrixXd C = AttitudeCovariance(model);
    const auto G = effect_.bottomRows(3 * T);
    ErrorEffect effect = PositionEffect(model.position);
    effect.attitude = G.transpose() * C * G;
    effect.attitude_chi2 = H_P_.bottomRightCorner(3 * T, 3 * T).cwiseProduct(C).sum();
    effect.tau_s = CorrelationTime(model);
    effects_.push_back(effect);

    const MatrixXd L_p = Root(Unit(model.position)), L_a = Root(C);
    const auto position = [&](int c) { return Eigen::seqN(c * T, T); };
    const auto attitude = Eigen::lastN(3 * T);
    MatrixXd M(6 * T, 6 * T);
    VectorXd c(6 * T);
    MatrixXd HL(6 * T, 6 * T);
    for (int a = 0; a < 3; ++a)
      HL(Eigen::all, position(a)).noalias() = H_P_(Eigen::all, position(a)) * L_p;
    HL(Eigen::all, attitude).noalias() = H_P_(Eigen::all, attitude) * L_a;
    for (int a = 0; a < 3; ++a) {
      M(position(a), Eigen::all).noalias() = L_p.transpose() * HL(position(a), Eigen::all);
      c(position(a)).noalias() = L_p.transpose() * b_(position(a));
    }
    M(attitude, Eigen::all).noalias() = L_a.transpose() * HL(attitude, Eigen::all);
    c(attitude).noalias() = L_a.transpose() * b_(attitude);
    effects_.back().square = M.squaredNorm();
    AddSizes(M, c);
  }

  // Adds grid points. A smoother states position and attitude with a common scale, and the larger
  // the constant share, the smaller the varying part of the attitude error. For a data sheet the
  // two scales are independent.
  void AddSizes(const MatrixXd& M, const VectorXd& c) {
    if (!by_smoother_) {
      for (const double log2_ratio : kLog2Ratios) {
        const double position = std::exp2(log2_ratio);
        std::vector<Sizes> sizes;
        for (const auto& [share, weight] : kConstantShares) {
          if (share < 1.0) sizes.push_back(MakeSizes(position, share, weight));
        }
        AddPoints(Reduce(Scaled(M, position), Scaled(c, position)), sizes);
      }
      return;
    }
    for (const auto& [share, weight] : kConstantShares) {
      if (share == 1.0) continue;
      const double position = 1.0 / std::sqrt(1.0 - share);
      AddPoints(Reduce(Scaled(M, position), Scaled(c, position)),
                {MakeSizes(position, share, weight)});
    }
  }

  static Sizes MakeSizes(double position, double share, double weight) {
    return {position, 1.0 / std::sqrt(1.0 - share), share, std::log(weight)};
  }

  // Adds the model in which the attitude error is constant over the flight and does not affect the
  // misclosures.
  void AddConstantAttitude(const ErrorProcess& position) {
    const int T = nodes_.size();
    effects_.push_back(PositionEffect(position));
    effects_.back().attitude = NoEffect();
    const MatrixXd L = Root(Unit(position));
    MatrixXd M(3 * T, 3 * T);
    VectorXd c(3 * T);
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        M.block(a * T, b * T, T, T) = L.transpose() * H_P_.block(a * T, b * T, T, T) * L;
      }
      c.segment(a * T, T) = L.transpose() * b_.segment(a * T, T);
    }
    // The constant model has the same total prior weight as the varying models together.
    const auto& [share, weight] = std::end(kConstantShares)[-1];
    const double log_weight =
        std::log(weight * static_cast<double>(by_smoother_ ? std::size(kAttitudeErrors)
                                                           : DataSheetModels().size() /
                                                                 std::size(kPositionTaus_s)));
    std::vector<Sizes> sizes;
    if (by_smoother_) sizes.push_back({1.0, 1.0, share, log_weight});
    if (!by_smoother_) {
      for (const double log2_ratio : kLog2Ratios) {
        sizes.push_back({1.0, std::exp2(-log2_ratio), share, log_weight});
      }
    }
    effects_.back().square = M.squaredNorm();
    AddPoints(Reduce(M, c), sizes);
  }

  ErrorEffect PositionEffect(const ErrorProcess& process) {
    const int T = nodes_.size();
    const MatrixXd& K = Unit(process);
    ErrorEffect effect;
    effect.position = NoEffect();
    for (int c = 0; c < 3; ++c) {
      const auto G = effect_.middleRows(c * T, T);
      effect.position += G.transpose() * K * G;
      effect.position_chi2 += H_P_.block(c * T, c * T, T, T).cwiseProduct(K).sum();
    }
    return effect;
  }

  MatrixXd NoEffect() const { return MatrixXd::Zero(effect_.cols(), effect_.cols()); }

  MatrixXd Scaled(MatrixXd M, double position) const {
    const int T = nodes_.size();
    M.topRows(3 * T) *= position;
    M.leftCols(3 * T) *= position;
    return M;
  }
  VectorXd Scaled(VectorXd c, double position) const {
    c.head(3 * nodes_.size()) *= position;
    return c;
  }

  static Information Reduce(const MatrixXd& M, const VectorXd& c) {
    const Eigen::Tridiagonalization<MatrixXd> tridiagonal(M);
    return {tridiagonal.diagonal(), tridiagonal.subDiagonal(), tridiagonal.matrixQ().adjoint() * c};
  }

  // Adds grid points for the last element of effects_: one for each error scale s and each of
  // `sizes`.
  void AddPoints(const Information& information, const std::vector<Sizes>& sizes) {
    for (int step = kRhoStepsPerOctave * kFirstRhoOctave;
         step <= kRhoStepsPerOctave * kLastRhoOctave; ++step) {
      const double rho = std::exp2(static_cast<double>(step) / kRhoStepsPerOctave);
      const TridiagonalFigures figures =
          Evaluate(information.diagonal, information.sub, information.c, rho);
      // Except for rounding, correlated errors cannot explain more than the total sum of squares.
      const double s0_2 = std::max(chi2_ - figures.explained, 1e-6 * chi2_) / nu_;
      const double log_likelihood = -0.5 * (nu_ * std::log(s0_2 * nu_ / chi2_) + figures.log_det);
      for (const Sizes& size : sizes) {
        GridPoint point;
        point.effect = effects_.size() - 1;
        point.s_p = size.position * std::sqrt(rho * s0_2);
        point.s_a = size.attitude * std::sqrt(rho * s0_2);
        point.constant_share = size.constant_share;
        point.log_prior = size.log_weight + LogPrior(point);
        point.log_posterior = log_likelihood + point.log_prior;
        grid_.push_back(point);
      }
    }
  }

  double LogPrior(const GridPoint& point) const {
    // Mean of log2 s for which the mean of s^2 is 1.
    const double mean = -Squared(octaves_) * std::numbers::ln2;
    const auto log_normal = [&](double s) {
      return -0.5 * Squared((std::log2(s) - mean) / octaves_);
    };
    return log_normal(point.s_a) + (by_smoother_ ? 0.0 : log_normal(point.s_p));
  }

  AdjustmentErrorCovariance Average() const {
    const auto log_sum = [&](double GridPoint::*value) {
      double largest = -std::numeric_limits<double>::infinity();
      for (const GridPoint& point : grid_) largest = std::max(largest, point.*value);
      double sum = 0.0;
      for (const GridPoint& point : grid_) sum += std::exp(point.*value - largest);
      return largest + std::log(sum);
    };
    const double evidence = log_sum(&GridPoint::log_posterior);
    AdjustmentErrorCovariance out{{}, NoEffect()};
    auto& [scatter, covariance] = out;
    double s_a2 = 0.0, s_p2 = 0.0, log_tau = 0.0, varying = 0.0, half_variance = nu_;
    for (const GridPoint& point : grid_) {
      const double weight = std::exp(point.log_posterior - evidence);
      const double p2 = Squared(point.s_p), a2 = Squared(point.s_a);
      s_a2 += weight * a2;
      s_p2 += weight * p2;
      scatter.constant_share += weight * point.constant_share * a2;
      const ErrorEffect& effect = effects_[point.effect];
      const double added =
          effect.position_chi2 + (1.0 - point.constant_share) * effect.attitude_chi2;
      scatter.expected_ratio += weight * added / nu_;
      half_variance += weight * (2.0 * added + effect.square);
      if (effect.tau_s > 0.0) {
        varying += weight;
        log_tau += weight * std::log(effect.tau_s);
      }
      covariance +=
          weight * (p2 * effect.position + (1.0 - point.constant_share) * a2 * effect.attitude);
    }
    scatter.covariance_rad2 = covariance.topLeftCorner<3, 3>();
    scatter.other_variances = covariance.diagonal().tail(covariance.rows() - 3);
    scatter.expected_dof = Squared(scatter.expected_ratio * nu_) / half_variance;
    scatter.attitude_ratio = std::sqrt(s_a2);
    scatter.position_ratio = std::sqrt(s_p2);
    if (varying > 0.0) scatter.tau_s = std::exp(log_tau / varying);
    scatter.evidence_nats = evidence - log_sum(&GridPoint::log_prior);
    scatter.nodes = nodes_.size();
    return out;
  }

  bool by_smoother_;
  double octaves_;  // standard deviation of the scale's prior
  double nu_;
  const TimeNodes& nodes_;
  VectorXd heading_rad_;
  MatrixXd effect_;  // N_e N^-1
  MatrixXd H_P_;
  VectorXd b_;
  double chi2_;
  std::vector<std::pair<ErrorProcess, MatrixXd>> covariances_;
  std::vector<ErrorEffect> effects_;
  std::vector<GridPoint> grid_;
};

/// Adds an epoch in the middle between consecutive epochs of a strip. Over short times the attitude
/// error from gyros is a random walk. Its midpoint then deviates from linear interpolation with a
/// quarter of the variance of the difference. In symbols, e_m = (e_a + e_b) / 2 + n, n ~ N(0, D[e_b
/// - e_a] / 4).
PoseCovariance Refined(const PoseCovariance& stated) {
  struct Row {
    Eigen::Index a, b;
  };
  PoseCovariance out;
  std::vector<Row> rows;
  for (std::size_t k = 0; k < stated.t_s.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (k > 0 && stated.strip[k] == stated.strip[k - 1]) {
      rows.push_back({at - 1, at});
      out.t_s.push_back(0.5 * (stated.t_s[k - 1] + stated.t_s[k]));
      out.strip.push_back(stated.strip[k]);
    }
    rows.push_back({at, at});
    out.t_s.push_back(stated.t_s[k]);
    out.strip.push_back(stated.strip[k]);
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  MatrixXd P = MatrixXd::Zero(6 * n, stated.covariance.rows());
  MatrixXd bend = MatrixXd::Zero(6 * n, 6 * n);
  const Matrix6d I = Matrix6d::Identity();
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto [a, b] = rows[static_cast<std::size_t>(k)];
    P.block<6, 6>(6 * k, 6 * a) += 0.5 * I;
    P.block<6, 6>(6 * k, 6 * b) += 0.5 * I;
    const auto C = [&](Eigen::Index i, Eigen::Index j) {
      return stated.covariance.block<6, 6>(6 * i, 6 * j);
    };
    bend.block<6, 6>(6 * k, 6 * k) = 0.25 * (C(a, a) + C(b, b) - C(a, b) - C(b, a));
  }
  out.covariance = P * stated.covariance * P.transpose() + bend;
  return out;
}

/// Reorders a matrix with six rows per node to the order of NodeSums.
MatrixXd ByComponent(const MatrixXd& by_node) {
  const Eigen::Index T = by_node.rows() / 6;
  const auto from = [&](Eigen::Index row) { return 6 * (row % T) + row / T; };
  return MatrixXd::NullaryExpr(6 * T, 6 * T, [&](Eigen::Index row, Eigen::Index column) {
    return by_node(from(row), from(column));
  });
}

}  // namespace

void PoseCovariance::Validate() const {
  const std::size_t T = t_s.size();
  if (T == 0 || strip.size() != T || covariance.rows() != static_cast<Eigen::Index>(6 * T) ||
      covariance.cols() != covariance.rows()) {
    throw InvalidConfig("the covariance of the trajectory is for " + std::to_string(T) +
                        " epochs, but has " + std::to_string(covariance.rows()) + " x " +
                        std::to_string(covariance.cols()) +
                        " elements; six rows and columns per epoch are needed");
  }
  for (std::size_t k = 1; k < T; ++k) {
    if (!(t_s[k] > t_s[k - 1]) || strip[k] < strip[k - 1]) {
      throw InvalidConfig("the epochs of the covariance of the trajectory do not increase");
    }
  }
  if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() > 0.0)) {
    throw InvalidConfig("a variance of the trajectory is not positive");
  }
  constexpr double kRounding = 1e-6;
  const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd R = scale.asDiagonal() * covariance * scale.asDiagonal();
  const auto order = static_cast<Eigen::Index>(6 * T);
  if (Eigen::LLT<MatrixXd>(R + kRounding * MatrixXd::Identity(order, order)).info() !=
      Eigen::Success) {
    throw InvalidConfig("the covariance of the trajectory is not positive definite");
  }
}

void TrajectoryErrorOptions::Validate() const {
  if (covariance) {
    covariance->Validate();
    return;
  }
  for (const Vector3d& sigma : {sigma_ned_m, sigma_rph_rad}) {
    if (!sigma.allFinite() || !(sigma.minCoeff() > 0.0)) {
      throw InvalidConfig("the sigmas of the trajectory must be positive and finite");
    }
  }
  if (max_nodes < 2) {
    throw InvalidConfig("max_nodes is " + std::to_string(max_nodes) + ", must be at least 2");
  }
}

CorrelatedErrorCovariance EstimateCorrelatedErrorCovariance(const GaussHelmertProblem& problem,
                                                            const GaussHelmertResult& result,
                                                            BoresightModel model,
                                                            const TrajectoryErrorOptions& options) {
  options.Validate();
  if (result.weights.size() != problem.pairs.size() ||
      result.corrections.size() != problem.pairs.size()) {
    throw InvalidInput("the adjustment has " + std::to_string(result.weights.size()) +
                       " pairs, the problem " + std::to_string(problem.pairs.size()));
  }
  if (!(result.chi2 > 0.0)) {  // all misclosures are zero
    CorrelatedErrorCovariance none;
    none.other_variances = VectorXd::Zero(problem.laser.size());
    return none;
  }
  return fixed_trajectory_internal::EstimateFromNodeSums(
             static_cast<double>(result.redundancy), options,
             [&] { return Epochs(problem, result.weights); },
             [&](const TimeNodes& nodes) {
               return fixed_trajectory_internal::SumPairConditions(problem, result, model, options,
                                                                   nodes);
             })
      .scatter;
}

AdjustmentErrorCovariance fixed_trajectory_internal::EstimateFromNodeSums(
    double redundancy, const TrajectoryErrorOptions& options,
    const std::function<std::vector<double>()>& epochs_s,
    const std::function<NodeSums(const TimeNodes&)>& sums) {
  if (options.covariance) {
    const PoseCovariance stated = Refined(*options.covariance);
    const TimeNodes nodes(stated.t_s, stated.strip);
    return ScatterEstimator(redundancy, nodes, sums(nodes), SigmaSource::kSmoother)
        .Run(ByComponent(stated.covariance));
  }
  const TimeNodes nodes(epochs_s(), options.strip_begin_s, options.max_nodes);
  return ScatterEstimator(redundancy, nodes, sums(nodes), options.sigma_source).Run();
}

double ReliableVarianceFactor(double sigma0, double chi2, long redundancy) {
  constexpr double kAssumed = 10.0;  // weight of the assumed noise, in observations
  return std::max(sigma0 * sigma0,
                  (chi2 + kAssumed) / (static_cast<double>(redundancy) + kAssumed - 2.0));
}

}  // namespace dn
