#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/solvers/trajectory_scatter.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "gauss_helmert_pair.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Correlation in time of the errors that the grid holds.
struct Correlation {
  double tau_s;
  bool across_strips;  ///< false: the turns between the strips break it
};
constexpr double kForEver_s = 1e7;
constexpr double kLongestTau_s = 1000.0;  // that is reported
constexpr Correlation kVaryingErrors[] = {{3.0, true},   {10.0, true},  {30.0, true},
                                          {100.0, true}, {300.0, true}, {1000.0, true}};
// Gyros carry a smoothed attitude over many GNSS epochs, so that the rest of its error changes over
// tens of seconds at least; turns make it observable, and what follows them is another error.
constexpr Correlation kErrorsOfSmoother[] = {
    {30.0, true},   {100.0, true},   {300.0, true},       {1000.0, true},    {100.0, false},
    {300.0, false}, {1000.0, false}, {kForEver_s, false}, {kForEver_s, true}};
constexpr double kLog2Ratios[] = {-3.0, -1.5, 0.0, 1.5, 3.0};  // of s_p / s_a
constexpr double kRatioPriorOctaves = 1.5;
/// Log-normal prior of s_a, in octaves.
struct ScalePrior {
  double mean, sigma;
};
constexpr ScalePrior kVaryingPart{-1.0, 1.0};
constexpr ScalePrior kWholeError{0.0, 0.4};
// Of (s_a / s0)^2, in octaves: from an error without any effect to one of 32 times the stated
// sigma.
constexpr int kFirstRhoOctave = -16;
constexpr int kLastRhoOctave = 10;
constexpr double kShortestBlockS = 1.0;
constexpr double kStripGap_s = 5.0;  // without pairs, between two strips

/// Blocks of time that hold the epochs of the pairs.
struct TimeBlocks {
  std::vector<double> begin_s, mid_s, length_s;
  std::vector<int> strip;

  int size() const { return static_cast<int>(mid_s.size()); }
  int At(double t_s) const {
    return static_cast<int>(std::upper_bound(begin_s.begin(), begin_s.end(), t_s) -
                            begin_s.begin()) -
           1;
  }
};

TimeBlocks Cut(const std::vector<double>& t_s, double longest_s) {
  TimeBlocks blocks;
  for (const double t : t_s) {
    if (blocks.begin_s.empty() || t - blocks.begin_s.back() > longest_s) {
      blocks.begin_s.push_back(t);
      blocks.length_s.push_back(0.0);
    }
    blocks.length_s.back() = t - blocks.begin_s.back();
  }
  for (std::size_t b = 0; b < blocks.begin_s.size(); ++b) {
    blocks.mid_s.push_back(blocks.begin_s[b] + 0.5 * blocks.length_s[b]);
    const bool first = b == 0;
    const double gap_s =
        first ? 0.0 : blocks.begin_s[b] - blocks.begin_s[b - 1] - blocks.length_s[b - 1];
    const bool turn = gap_s > std::max(kStripGap_s, longest_s);
    blocks.strip.push_back(first ? 0 : blocks.strip.back() + (turn ? 1 : 0));
  }
  return blocks;
}

TimeBlocks MakeBlocks(const GaussHelmertProblem& problem, const std::vector<double>& weights,
                      int max_blocks) {
  std::vector<double> t_s;
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    if (weights[k] == 0.0) continue;
    t_s.push_back(problem.pairs[k].i.t_s);
    t_s.push_back(problem.pairs[k].j.t_s);
  }
  std::sort(t_s.begin(), t_s.end());
  TimeBlocks blocks = Cut(t_s, kShortestBlockS);
  constexpr double kGrowth = 1.25;
  for (double longest_s = kGrowth * kShortestBlockS; blocks.size() > max_blocks;
       longest_s *= kGrowth) {
    blocks = Cut(t_s, longest_s);
  }
  return blocks;
}

/// Sums over the pairs with the errors of a block in units of their stated sigmas. Unknown c of
/// block n stands at c * blocks + n: position north, east, down, roll, pitch, heading.
struct BlockSums {
  MatrixXd H, N_e;
  VectorXd b;
  Matrix3d N = Matrix3d::Zero();
  Vector3d g = Vector3d::Zero();  // A^T S w: zero, unless the estimate had other weights
  double chi2 = 0.0;
};

using EndJacobian = Eigen::Matrix<double, 3, 6>;

EndJacobian ScaledJacobian(const GaussHelmertEnd& end, const Matrix3d& J_phi,
                           const TrajectoryScatterOptions& options) {
  const Vector3d down_b = end.q_mb.conjugate() * (end.q_mn * Vector3d::UnitZ());
  EndJacobian J;
  J << end.q_mn.toRotationMatrix() * options.sigma_ned_m.asDiagonal(),
      J_phi * BodyFromEulerRates(down_b) * options.sigma_rph_rad.asDiagonal();
  return J;
}

Matrix3d MisclosureWeight(const GaussHelmertPair& pair, const PairLinearisation& linear) {
  Matrix3d M = pair.covariance_m2;
  int column = 3;
  for (const GaussHelmertEnd* end : {&pair.i, &pair.j}) {
    const internal::EndNoise noise = internal::EvaluateNoise(*end);
    const Matrix3d L = linear.B.middleCols<3>(column) * noise.attitude_factor;
    M += noise.position + L * L.transpose();
    column += 6;
  }
  return M.inverse();
}

BlockSums Accumulate(const GaussHelmertProblem& problem, const GaussHelmertResult& result,
                     BoresightModel model, const TrajectoryScatterOptions& options,
                     const TimeBlocks& blocks) {
  const int T = blocks.size();
  BlockSums sums;
  sums.H.setZero(6 * T, 6 * T);
  sums.N_e.setZero(6 * T, 3);
  sums.b.setZero(6 * T);
  if (problem.boresight_sigma_rad) {
    sums.N = problem.boresight_sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
  }
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    if (result.weights[k] == 0.0) continue;
    const GaussHelmertPair& pair = problem.pairs[k];
    const PairCorrection& v = result.corrections[k];
    const PairLinearisation linear =
        LinearisePair(pair, problem.lever_arm_b_m, model, result.boresight_rad, v);
    const Vector3d w = linear.w - linear.B * v;
    const Matrix3d S = result.weights[k] * MisclosureWeight(pair, linear);
    const Matrix3d AtS = linear.A.transpose() * S;
    sums.N += AtS * linear.A;
    sums.g += AtS * w;
    sums.chi2 += w.dot(S * w);
    const int at[] = {blocks.At(pair.i.t_s), blocks.At(pair.j.t_s)};
    const EndJacobian J[] = {
        ScaledJacobian(pair.i, linear.B.middleCols<3>(3), options),
        EndJacobian(ScaledJacobian(pair.j, -linear.B.middleCols<3>(9), options) * -1.0)};
    for (int e = 0; e < 2; ++e) {
      const Eigen::Matrix<double, 6, 3> JtS = J[e].transpose() * S;
      const Eigen::Matrix<double, 6, 3> N_e = JtS * linear.A;
      const Eigen::Matrix<double, 6, 1> b = JtS * w;
      for (int c = 0; c < 6; ++c) {
        sums.N_e.row(c * T + at[e]) += N_e.row(c);
        sums.b[c * T + at[e]] += b[c];
      }
      for (int f = 0; f < 2; ++f) {
        const Eigen::Matrix<double, 6, 6> H = JtS * J[f];
        for (int c = 0; c < 6; ++c) {
          for (int d = 0; d < 6; ++d) sums.H(c * T + at[e], d * T + at[f]) += H(c, d);
        }
      }
    }
  }
  return sums;
}

/// Covariance of the averages over the blocks of a Gauss-Markov process of unit variance.
MatrixXd BlockKernel(const TimeBlocks& blocks, const Correlation& correlation) {
  const double tau_s = correlation.tau_s;
  const int T = blocks.size();
  VectorXd attenuation(T);  // of the covariance with anything outside the block
  MatrixXd K(T, T);
  for (int n = 0; n < T; ++n) {
    const double x = blocks.length_s[static_cast<std::size_t>(n)] / tau_s;
    constexpr double kSeries = 1e-3;  // below it the series is exact to 1e-9
    attenuation[n] = x < kSeries ? 1.0 + x * x / 24.0 : 2.0 / x * std::sinh(0.5 * x);
    K(n, n) = x < kSeries ? 1.0 - x / 3.0 + x * x / 12.0 : 2.0 / (x * x) * (x + std::expm1(-x));
  }
  for (int n = 0; n < T; ++n) {
    for (int m = 0; m < n; ++m) {
      const bool same_strip =
          blocks.strip[static_cast<std::size_t>(n)] == blocks.strip[static_cast<std::size_t>(m)];
      if (!same_strip && !correlation.across_strips) {
        K(n, m) = K(m, n) = 0.0;
        continue;
      }
      const double apart_s = std::abs(blocks.mid_s[static_cast<std::size_t>(n)] -
                                      blocks.mid_s[static_cast<std::size_t>(m)]);
      K(n, m) = K(m, n) = attenuation[n] * attenuation[m] * std::exp(-apart_s / tau_s);
    }
  }
  return K;
}

/// log det(I + rho T) and c^T (I/rho + T)^-1 c of a symmetric tridiagonal T >= 0.
struct TridiagonalFigures {
  double log_det = 0.0;
  double explained = 0.0;
};

TridiagonalFigures Evaluate(const VectorXd& diagonal, const VectorXd& sub, const VectorXd& c,
                            double rho) {
  TridiagonalFigures out;
  double pivot = 0.0, forward = 0.0;  // L D L^T and the forward substitution with it
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    const double off = i == 0 ? 0.0 : rho * sub[i - 1];
    const double next = 1.0 + rho * diagonal[i] - (i == 0 ? 0.0 : off * off / pivot);
    forward = c[i] - (i == 0 ? 0.0 : off / pivot * forward);
    pivot = std::max(next, 1.0);  // as the eigenvalues of I + rho T, but for rounding
    out.log_det += std::log(pivot);
    out.explained += rho * forward * forward / pivot;
  }
  return out;
}

/// One point of the grid over (s_p, s_a, tau).
struct GridPoint {
  double log_posterior = 0.0;
  double s_p = 0.0, s_a = 0.0;
  std::size_t effect = 0;
};

/// What errors of unit size and one correlation do to the boresight.
struct ErrorEffect {
  Correlation correlation;
  Matrix3d position_rad2, attitude_rad2;

  bool IsConstant() const { return correlation.tau_s == kForEver_s && correlation.across_strips; }
};

class ScatterEstimator {
 public:
  ScatterEstimator(double redundancy, const TimeBlocks& blocks, const BlockSums& sums,
                   bool whole_error)
      : whole_error_(whole_error),
        nu_(redundancy),
        blocks_(blocks),
        effect_(sums.N_e * sums.N.inverse()),
        H_P_(sums.H - effect_ * sums.N_e.transpose()),
        b_(sums.b - effect_ * sums.g),
        chi2_(sums.chi2 - sums.g.dot(sums.N.llt().solve(sums.g))) {}

  TrajectoryScatter Run() {
    if (whole_error_) {
      for (const Correlation& correlation : kErrorsOfSmoother) Add(correlation);
    } else {
      for (const Correlation& correlation : kVaryingErrors) Add(correlation);
    }
    return Average();
  }

 private:
  // The part of unit processes in the boresight: of the positions and of the attitudes.
  Matrix3d Effect(const MatrixXd& K, int first) const {
    const int T = blocks_.size();
    Matrix3d C = Matrix3d::Zero();
    for (int c = first; c < first + 3; ++c) {
      const auto G = effect_.middleRows(c * T, T);
      C += G.transpose() * K * G;
    }
    return C;
  }

  void Add(const Correlation& correlation) {
    const int T = blocks_.size();
    const MatrixXd K = BlockKernel(blocks_, correlation);
    effects_.push_back({correlation, Effect(K, 0), Effect(K, 3)});
    constexpr double kRounding = 1e-10;  // of the positive definiteness of K
    const MatrixXd L = Eigen::LLT<MatrixXd>(K + kRounding * MatrixXd::Identity(T, T)).matrixL();
    MatrixXd M(6 * T, 6 * T);
    VectorXd c(6 * T);
    for (int a = 0; a < 6; ++a) {
      c.segment(a * T, T).noalias() = L.transpose() * b_.segment(a * T, T);
      for (int d = 0; d <= a; ++d) {
        M.block(a * T, d * T, T, T).noalias() = L.transpose() * H_P_.block(a * T, d * T, T, T) * L;
      }
    }
    M.triangularView<Eigen::StrictlyUpper>() = M.transpose();
    if (whole_error_) {  // a smoother states both, position and attitude
      AddRatio(0.0, M, c);
      return;
    }
    for (const double log2_ratio : kLog2Ratios) AddRatio(log2_ratio, M, c);
  }

  void AddRatio(double log2_ratio, MatrixXd M, VectorXd c) {
    const int T = blocks_.size();
    const double ratio = std::exp2(log2_ratio);
    M.topRows(3 * T) *= ratio;
    M.leftCols(3 * T) *= ratio;
    c.head(3 * T) *= ratio;
    const Eigen::Tridiagonalization<MatrixXd> tridiagonal(M);
    const VectorXd diagonal = tridiagonal.diagonal();
    const VectorXd sub = tridiagonal.subDiagonal();
    const VectorXd turned = tridiagonal.matrixQ().adjoint() * c;
    const auto squared = [](double x) { return x * x; };
    const ScalePrior& scale = whole_error_ ? kWholeError : kVaryingPart;
    for (int octave = kFirstRhoOctave; octave <= kLastRhoOctave; ++octave) {
      const double rho = std::exp2(octave);
      const TridiagonalFigures figures = Evaluate(diagonal, sub, turned, rho);
      // What the correlated errors explain cannot exceed all there is, but for rounding.
      const double s0_2 = std::max(chi2_ - figures.explained, 1e-6 * chi2_) / nu_;
      GridPoint point;
      point.effect = effects_.size() - 1;
      point.s_a = std::sqrt(rho * s0_2);
      point.s_p = ratio * point.s_a;
      const double log_likelihood = -0.5 * (nu_ * std::log(s0_2 * nu_ / chi2_) + figures.log_det);
      const double log_prior = -0.5 * squared(log2_ratio / kRatioPriorOctaves) -
                               0.5 * squared((std::log2(point.s_a) - scale.mean) / scale.sigma);
      point.log_posterior = log_likelihood + log_prior;
      grid_.push_back(point);
      log_prior_.push_back(log_prior);
    }
  }

  TrajectoryScatter Average() const {
    const auto log_sum = [](const auto& values, const auto& get) {
      double largest = -std::numeric_limits<double>::infinity();
      for (const auto& value : values) largest = std::max(largest, get(value));
      double sum = 0.0;
      for (const auto& value : values) sum += std::exp(get(value) - largest);
      return largest + std::log(sum);
    };
    const double evidence = log_sum(grid_, [](const GridPoint& p) { return p.log_posterior; });
    const double prior = log_sum(log_prior_, [](double p) { return p; });
    TrajectoryScatter scatter;
    if (whole_error_) scatter.constant_share = 0.0;
    double s_a2 = 0.0, s_p2 = 0.0, log_tau = 0.0, varying = 0.0;
    for (const GridPoint& point : grid_) {
      const double weight = std::exp(point.log_posterior - evidence);
      s_a2 += weight * point.s_a * point.s_a;
      s_p2 += weight * point.s_p * point.s_p;
      const ErrorEffect& effect = effects_[point.effect];
      if (effect.IsConstant()) {
        scatter.constant_share += weight * point.s_a * point.s_a;
        continue;
      }
      varying += weight;
      log_tau += weight * std::log(std::min(effect.correlation.tau_s, kLongestTau_s));
      scatter.covariance_rad2 += weight * (point.s_p * point.s_p * effect.position_rad2 +
                                           point.s_a * point.s_a * effect.attitude_rad2);
    }
    scatter.attitude_ratio = std::sqrt(s_a2);
    scatter.position_ratio = std::sqrt(s_p2);
    scatter.tau_s = std::exp(log_tau / varying);
    scatter.evidence_nats = evidence - prior;
    scatter.blocks = blocks_.size();
    return scatter;
  }

  bool whole_error_;
  double nu_;
  const TimeBlocks& blocks_;
  MatrixXd effect_;  // N_e N^-1
  MatrixXd H_P_;
  VectorXd b_;
  double chi2_;
  std::vector<ErrorEffect> effects_;
  std::vector<GridPoint> grid_;
  std::vector<double> log_prior_;
};

}  // namespace

void TrajectoryScatterOptions::Validate() const {
  for (const Vector3d& sigma : {sigma_ned_m, sigma_rph_rad}) {
    if (!sigma.allFinite() || !(sigma.minCoeff() > 0.0)) {
      throw InvalidConfig("the sigmas of the trajectory must be positive and finite");
    }
  }
  if (max_blocks < 2) {
    throw InvalidConfig("max_blocks is " + std::to_string(max_blocks) + ", must be at least 2");
  }
}

TrajectoryScatter EstimateTrajectoryScatter(const GaussHelmertProblem& problem,
                                            const GaussHelmertResult& result, BoresightModel model,
                                            const TrajectoryScatterOptions& options) {
  options.Validate();
  if (result.weights.size() != problem.pairs.size() ||
      result.corrections.size() != problem.pairs.size()) {
    throw InvalidInput("the adjustment has " + std::to_string(result.weights.size()) +
                       " pairs, the problem " + std::to_string(problem.pairs.size()));
  }
  if (!(result.chi2 > 0.0)) return {};  // no misclosure at all
  const TimeBlocks blocks = MakeBlocks(problem, result.weights, options.max_blocks);
  const BlockSums sums = Accumulate(problem, result, model, options, blocks);
  return ScatterEstimator(static_cast<double>(result.redundancy), blocks, sums,
                          options.of_whole_error)
      .Run();
}

Eigen::Matrix3d ReliableCovariance(const GaussHelmertResult& result,
                                   const TrajectoryScatter& scatter,
                                   const Eigen::Matrix3d& constant_rad2) {
  constexpr double kAssumed = 10.0;  // weight of the assumed noise, in observations
  const double factor = std::max(
      result.sigma0 * result.sigma0,
      (result.chi2 + kAssumed) / (static_cast<double>(result.redundancy) + kAssumed - 2.0));
  return factor * result.covariance_apriori_rad2 + scatter.covariance_rad2 + constant_rad2;
}

}  // namespace dn
