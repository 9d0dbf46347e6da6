#include <dn/error.h>
#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/median.h>
#include <dn/parallel.h>
#include <dn/rotation.h>
#include <dn/solvers/robust_loss.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "boresight_normal.h"
#include "gauss_helmert_normal.h"
#include "gauss_helmert_pair.h"
#include "laser_prior.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fixed_trajectory_internal::EndTerms;
using fixed_trajectory_internal::LaserColumns;
using fixed_trajectory_internal::NormalSolver;
using fixed_trajectory_internal::NormalSums;
using fixed_trajectory_internal::UnknownsChange;

constexpr std::size_t kChunk = 2048;  // pairs per partial sum
constexpr double kRoundingM = 1e-6;   // smaller differences are never outliers
constexpr double kFarRad = 1e-4;
constexpr int kLiborIterations = 5;
constexpr double kLiborToleranceRad = 1e-9;
constexpr double kRobustStartToleranceRad = 1e-6;

std::string EndName(std::size_t k, const char* which) {
  return "pair " + std::to_string(k) + ", end " + which;
}

bool PositiveAndFinite(const Vector3d& sigma) {
  return sigma.allFinite() && sigma.minCoeff() > 0.0;
}

void CheckEnd(const GaussHelmertEnd& end, const LaserUnknowns& laser, std::size_t k,
              const char* which) {
  constexpr double kUnit = 1e-6;
  if (!end.q_mb.coeffs().allFinite() || !end.q_mn.coeffs().allFinite() || !end.p_mb.allFinite()) {
    throw InvalidInput(EndName(k, which) + ": the pose is not finite");
  }
  if (std::abs(end.q_mb.norm() - 1.0) > kUnit || std::abs(end.q_mn.norm() - 1.0) > kUnit) {
    throw InvalidInput(EndName(k, which) + ": a quaternion does not have unit norm");
  }
  if (!end.u_b.allFinite() || !(end.u_b.norm() > 0.0)) {
    throw InvalidInput(EndName(k, which) + ": the laser vector is zero or not finite");
  }
  if (!PositiveAndFinite(end.sigma_ned_m) || !PositiveAndFinite(end.sigma_rph_rad)) {
    throw InvalidInput(EndName(k, which) +
                       ": a sigma of the trajectory is not positive and finite");
  }
  fixed_trajectory_internal::CheckLaserTerms(end.laser, laser, EndName(k, which));
}

bool SameEnd(const GaussHelmertEnd& a, const GaussHelmertEnd& b) {
  return a.q_mb.coeffs() == b.q_mb.coeffs() && a.p_mb == b.p_mb && a.u_b == b.u_b;
}

void CheckProblem(const GaussHelmertProblem& problem) {
  if (!problem.lever_arm_b_m.allFinite() || !problem.boresight_rad.allFinite()) {
    throw InvalidInput("the lever arm or the initial boresight is not finite");
  }
  if (problem.boresight_sigma_rad && !PositiveAndFinite(*problem.boresight_sigma_rad)) {
    throw InvalidInput("the sigma of the initial boresight is not positive and finite");
  }
  fixed_trajectory_internal::CheckLaserUnknowns(problem.laser);
  const std::vector<GaussHelmertPair>& pairs = problem.pairs;
  if (pairs.size() < 2) {
    throw InvalidInput("the boresight needs at least two point pairs, but the problem has " +
                       std::to_string(pairs.size()));
  }
  bool different = false;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    CheckEnd(pairs[k].i, problem.laser, k, "i");
    CheckEnd(pairs[k].j, problem.laser, k, "j");
    if (!pairs[k].covariance_m2.allFinite() ||
        Eigen::LLT<Matrix3d>(pairs[k].covariance_m2).info() != Eigen::Success) {
      throw InvalidInput("pair " + std::to_string(k) +
                         ": the covariance of its difference is not positive definite");
    }
    different = different || !SameEnd(pairs[k].i, pairs[0].i) || !SameEnd(pairs[k].j, pairs[0].j);
  }
  if (!different) {
    throw InvalidInput("all " + std::to_string(pairs.size()) +
                       " point pairs are identical; at least two different pairs are needed");
  }
}

class Adjuster {
 public:
  Adjuster(const GaussHelmertProblem& problem, const GaussHelmertOptions& options)
      : problem_(problem),
        options_(options),
        model_(options.libor_compat ? BoresightModel::kSmallAngle : options.model),
        theta_(problem.boresight_rad),
        laser_(VectorXd::Zero(problem.laser.size())),
        R_me_(problem.q_me.toRotationMatrix()) {
    const std::size_t n = problem.pairs.size();
    result_.weights.assign(n, 1.0);
    result_.corrections.assign(n, PairCorrection::Zero());
    norms_m_.resize(n);
  }

  GaussHelmertResult Run() {
    UpdateNorms();
    result_.residual_initial_m = MeanNorm();
    if (options_.loss.type == Loss::Type::kNone) {
      RunLeastSquares();
    } else {
      RunRobust();
    }
    Finish();
    return std::move(result_);
  }

 private:
  struct PairTerms {
    Vector3d w;  // w~ = w - B v
    Matrix3d A, S;
    LaserColumns laser;
    fixed_trajectory_internal::PoseNoise noise_i, noise_j;
    Matrix3d L_i, L_j;  // d w / d attitude times the factor of the attitude covariance
  };

  // Calls work(chunk, first, past) for all chunks of pairs, in parallel.
  template <class Work>
  void ForChunks(const Work& work) const {
    ParallelForChunks(problem_.pairs.size(), kChunk, options_.threads, work);
  }

  bool has_laser() const { return laser_.size() > 0; }

  /// Returns the laser vector at the present laser unknowns.
  Vector3d Vector(const GaussHelmertEnd& end) const {
    return has_laser() ? Vector3d(end.u_b + VectorChange(end.laser, laser_)) : end.u_b;
  }

  PairTerms Terms(std::size_t k) const {
    const GaussHelmertPair& pair = problem_.pairs[k];
    const PairCorrection& v = result_.corrections[k];
    const EndTerms i = fixed_trajectory_internal::EvaluateEnd(
        pair.i, Vector(pair.i), problem_.lever_arm_b_m, model_, theta_, q_theta_, v.segment<3>(0),
        v.segment<3>(3));
    const EndTerms j = fixed_trajectory_internal::EvaluateEnd(
        pair.j, Vector(pair.j), problem_.lever_arm_b_m, model_, theta_, q_theta_, v.segment<3>(6),
        v.segment<3>(9));
    PairTerms terms;
    terms.A = i.J_theta - j.J_theta;
    if (has_laser()) {
      terms.laser = fixed_trajectory_internal::PairLaserColumns(pair, model_, theta_, v);
    }
    terms.noise_i = fixed_trajectory_internal::EvaluateNoise(pair.i);
    terms.noise_j = fixed_trajectory_internal::EvaluateNoise(pair.j);
    Matrix3d B_i = i.J_phi, B_j = -j.J_phi;
    if (options_.libor_compat) TurnAsLibor(pair, &terms, &B_i, &B_j);
    terms.L_i.noalias() = B_i * terms.noise_i.attitude_factor;
    terms.L_j.noalias() = B_j * terms.noise_j.attitude_factor;
    terms.w = i.x - j.x - (v.segment<3>(0) - v.segment<3>(6)) - B_i * v.segment<3>(3) -
              B_j * v.segment<3>(9);
    Matrix3d M = pair.covariance_m2 + terms.noise_i.position + terms.noise_j.position;
    M.noalias() += terms.L_i * terms.L_i.transpose();
    M.noalias() += terms.L_j * terms.L_j.transpose();
    terms.S = M.inverse();
    return terms;
  }

  // Rotates the noise as libor does, by R_me alone. The position sigmas then lie along ECEF axes,
  // and the derivatives of R_nb lack the factor R_en.
  void TurnAsLibor(const GaussHelmertPair& pair, PairTerms* terms, Matrix3d* B_i,
                   Matrix3d* B_j) const {
    const auto turn = [&](const GaussHelmertEnd& end, fixed_trajectory_internal::PoseNoise* noise,
                          Matrix3d* B) {
      const Matrix3d L = R_me_ * end.sigma_ned_m.asDiagonal();
      noise->position = L * L.transpose();
      *B = R_me_ * end.q_mn.toRotationMatrix().transpose() * *B;
    };
    turn(pair.i, &terms->noise_i, B_i);
    turn(pair.j, &terms->noise_j, B_j);
  }

  NormalSums Accumulate() {
    std::vector<NormalSums> partial(NumChunks(problem_.pairs.size(), kChunk),
                                    NormalSums(laser_.size()));
    ForChunks([&](std::size_t c, std::size_t first, std::size_t past) {
      for (std::size_t k = first; k < past; ++k) {
        if (result_.weights[k] == 0.0) continue;
        const PairTerms terms = Terms(k);
        const Vector3d lambda = terms.S * terms.w;
        const double d2 = terms.w.dot(lambda);
        if (loss_.type != Loss::Type::kNone) {
          result_.weights[k] = EvaluateLoss(loss_, d2).rho_prime;
        }
        const double weight = result_.weights[k];
        const Matrix3d AtS = weight * terms.A.transpose() * terms.S;
        partial[c].N.noalias() += AtS * terms.A;
        partial[c].g.noalias() += AtS * terms.w;
        if (has_laser()) partial[c].AddLaser(terms.laser, weight * terms.S, terms.A, terms.w);
        partial[c].chi2 += weight * d2;
        partial[c].chi2_conditions += weight * lambda.dot(problem_.pairs[k].covariance_m2 * lambda);
      }
    });
    NormalSums sums(laser_.size());
    for (const NormalSums& part : partial) sums += part;
    AddPrior(&sums);
    return sums;
  }

  void AddPrior(NormalSums* sums) const {
    if (has_laser()) {
      const fixed_trajectory_internal::LaserPrior prior =
          fixed_trajectory_internal::EvaluateLaserPrior(problem_.laser, laser_);
      sums->N_laser += problem_.laser.information;
      sums->g_laser += prior.g;
      sums->chi2 += prior.chi2;
    }
    if (!problem_.boresight_sigma_rad) return;
    const fixed_trajectory_internal::BoresightPrior prior =
        fixed_trajectory_internal::EvaluatePrior(problem_.boresight_rad,
                                                 *problem_.boresight_sigma_rad, model_, theta_);
    sums->N += prior.N;
    sums->g += prior.g;
    sums->chi2 += prior.chi2;
  }

  // Computes v = -P^-1 B^T S (A d + w~) with the terms at which d was computed.
  void UpdateCorrections(const UnknownsChange& change) {
    ForChunks([&](std::size_t, std::size_t first, std::size_t past) {
      for (std::size_t k = first; k < past; ++k) {
        const PairTerms terms = Terms(k);
        Vector3d w = terms.A * change.boresight + terms.w;
        for (int a = 0; a < terms.laser.size(); ++a) {
          w +=
              change.laser[terms.laser.unknown[static_cast<std::size_t>(a)]] * terms.laser.A.col(a);
        }
        const Vector3d lambda = terms.S * w;
        PairCorrection& v = result_.corrections[k];
        v.segment<3>(0) = -terms.noise_i.position * lambda;
        v.segment<3>(3) = -terms.noise_i.attitude_factor * (terms.L_i.transpose() * lambda);
        v.segment<3>(6) = terms.noise_j.position * lambda;
        v.segment<3>(9) = -terms.noise_j.attitude_factor * (terms.L_j.transpose() * lambda);
      }
    });
  }

  static void CheckRank(const Matrix3d& N) {
    fixed_trajectory_internal::CheckBoresightRank(
        N, "point pairs", "add pairs between strips with other headings or heights");
  }

  Vector3d Step() {
    const NormalSums sums = Accumulate();
    const NormalSolver solver(sums);
    CheckRank(solver.N());
    const UnknownsChange change = solver.Solve();
    const Vector3d& d = change.boresight;
    // The first step may be several degrees. Corrections computed from the misclosures before such
    // a step would be useless.
    const bool far = result_.iterations == 0 && d.norm() > kFarRad;
    if (!options_.libor_compat && !far) UpdateCorrections(change);
    if (has_laser()) laser_ += change.laser;
    SetBoresight(model_ == BoresightModel::kExponential ? Log(Eigen::Quaterniond(Exp(d) * q_theta_))
                                                        : Vector3d(theta_ + d));
    ++result_.iterations;
    return d;
  }

  void SetBoresight(const Vector3d& theta_rad) {
    theta_ = theta_rad;
    q_theta_ = Exp(theta_rad);
  }

  // Stops when the next step, predicted from the ratio of the last two, is below the tolerance. The
  // ratio hardly depends on the weights, so the ratio from before the outlier step is reused after
  // it.
  bool Iterate(int max_iterations, double tolerance_rad) {
    double previous = 0.0;
    for (int i = 0; i < max_iterations; ++i) {
      const double step = Step().norm();
      if (previous > 0.0) rate_ = step / previous;
      if (step <= tolerance_rad || step * rate_ <= tolerance_rad) return true;
      previous = step;
    }
    return false;
  }

  void RunLeastSquares() {
    const bool libor = options_.libor_compat;
    const int most = libor ? kLiborIterations : options_.max_iterations;
    const double tolerance = libor ? kLiborToleranceRad : options_.tolerance_rad;
    result_.converged = Iterate(most, tolerance);
    if (options_.outlier_medians <= 0.0 || !result_.converged || !DropOutliers()) return;
    if (libor) {
      Step();
    } else {
      result_.converged = Iterate(most, tolerance);
    }
  }

  // A redescending loss has many local minima, so it starts from the solution of the convex Huber
  // loss.
  void RunRobust() {
    loss_ = {Loss::Type::kHuber, options_.loss.width};
    Iterate(options_.max_iterations, kRobustStartToleranceRad);
    loss_ = options_.loss;
    rate_ = 1.0;
    result_.converged = Iterate(options_.max_iterations, options_.tolerance_rad);
  }

  // Returns the georeferenced point with the given trajectory, without corrections.
  Vector3d Point(const GaussHelmertEnd& end) const {
    return end.p_mb + end.q_mb * Vector3d(fixed_trajectory_internal::BodyVector(Vector(end), model_,
                                                                                theta_, q_theta_) +
                                          problem_.lever_arm_b_m);
  }

  // Computes the distance |w| of every pair.
  void UpdateNorms() {
    ForChunks([&](std::size_t, std::size_t first, std::size_t past) {
      for (std::size_t k = first; k < past; ++k) {
        norms_m_[k] = (Point(problem_.pairs[k].i) - Point(problem_.pairs[k].j)).norm();
      }
    });
  }

  double MeanNorm() const {
    double sum = 0.0;
    double n = 0.0;
    for (std::size_t k = 0; k < norms_m_.size(); ++k) {
      if (result_.weights[k] == 0.0) continue;
      sum += norms_m_[k];
      n += 1.0;
    }
    return n > 0.0 ? sum / n : 0.0;
  }

  bool DropOutliers() {
    UpdateNorms();
    const double limit_m = std::max(options_.outlier_medians * Median(norms_m_), kRoundingM);
    bool dropped = false;
    for (std::size_t k = 0; k < norms_m_.size(); ++k) {
      if (norms_m_[k] <= limit_m) continue;
      result_.weights[k] = 0.0;
      dropped = true;
    }
    return dropped;
  }

  void Finish() {
    const NormalSums sums = Accumulate();
    const NormalSolver solver(sums);
    CheckRank(solver.N());
    result_.boresight_rad = theta_;
    result_.laser = problem_.laser.start + laser_;
    result_.laser_covariance_apriori = solver.LaserCovariance();
    result_.normal = solver.N();
    result_.covariance_apriori_rad2 = result_.normal.inverse();
    const Vector3d values = Eigen::SelfAdjointEigenSolver<Matrix3d>(result_.normal).eigenvalues();
    result_.condition_number = values[2] / values[0];
    result_.pairs_kept = std::count_if(result_.weights.begin(), result_.weights.end(),
                                       [](double weight) { return weight > 0.0; });
    result_.outliers = std::count_if(result_.weights.begin(), result_.weights.end(),
                                     [](double weight) { return weight < 0.5; });
    result_.redundancy = 3 * result_.pairs_kept - (problem_.boresight_sigma_rad ? 0 : 3);
    result_.chi2 = sums.chi2;
    result_.chi2_conditions = sums.chi2_conditions;
    NormalSums prior(laser_.size());
    AddPrior(&prior);
    result_.chi2_observations = sums.chi2 - sums.chi2_conditions - prior.chi2;
    result_.sigma0 = std::sqrt(sums.chi2 / static_cast<double>(result_.redundancy));
    result_.covariance_scaled_rad2 =
        result_.sigma0 * result_.sigma0 * result_.covariance_apriori_rad2;
    UpdateNorms();
    result_.residual_final_m = MeanNorm();
    if (options_.libor_compat) UpdateCorrections({Vector3d::Zero(), VectorXd::Zero(laser_.size())});
  }

  const GaussHelmertProblem& problem_;
  const GaussHelmertOptions& options_;
  const BoresightModel model_;
  Loss loss_;
  Vector3d theta_;
  VectorXd laser_;  // change of the laser unknowns from their start
  Eigen::Quaterniond q_theta_ = Exp(theta_);
  Matrix3d R_me_;
  std::vector<double> norms_m_;
  double rate_ = 1.0;  // ratio of the last two step lengths
  GaussHelmertResult result_;
};

}  // namespace

void GaussHelmertOptions::Validate() const {
  if (!(outlier_medians == 0.0 || outlier_medians > 1.0)) {
    throw InvalidConfig("outlier_medians is " + std::to_string(outlier_medians) +
                        ", must be 0 or above 1");
  }
  if (loss.type != Loss::Type::kNone && !(loss.width > 0.0 && std::isfinite(loss.width))) {
    throw InvalidConfig("the width of the robust loss is " + std::to_string(loss.width) +
                        ", must be positive");
  }
  if (libor_compat && loss.type != Loss::Type::kNone) {
    throw InvalidConfig("libor_compat cannot be combined with a robust loss; turn one of them off");
  }
  if (max_iterations < 1) {
    throw InvalidConfig("max_iterations is " + std::to_string(max_iterations) +
                        ", must be at least 1");
  }
  if (!(tolerance_rad > 0.0)) throw InvalidConfig("tolerance_rad must be positive");
  if (threads < 1) {
    throw InvalidConfig("threads is " + std::to_string(threads) + ", must be at least 1");
  }
}

Eigen::Matrix3d GaussHelmertResult::correlation() const {
  const Vector3d inverse = covariance_apriori_rad2.diagonal().cwiseSqrt().cwiseInverse();
  return inverse.asDiagonal() * covariance_apriori_rad2 * inverse.asDiagonal();
}

GaussHelmertResult AdjustGaussHelmert(const GaussHelmertProblem& problem,
                                      const GaussHelmertOptions& options) {
  options.Validate();
  CheckProblem(problem);
  return Adjuster(problem, options).Run();
}

}  // namespace dn
