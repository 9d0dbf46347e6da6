#include <dn/error.h>
#include <dn/fixed_trajectory/plane_adjustment.h>
#include <dn/median.h>
#include <dn/parallel.h>
#include <dn/rotation.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "boresight_normal.h"
#include "laser_prior.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kPlanesPerChunk = 16;  // planes per partial sum
constexpr long kMinStripPoints = 3;          // minimum number of points of a strip on a plane
// Ratio of the squared extents below which points are collinear.
constexpr double kLineRatio = 1e-10;
constexpr int kMaxSelections = 20;  // limit of the iterations of plane selection

std::string PointName(std::size_t plane, std::size_t point) {
  return "plane " + std::to_string(plane) + ", point " + std::to_string(point);
}

void CheckPoint(const PlanePoint& point, const LaserUnknowns& laser, std::size_t q, std::size_t k) {
  const GaussHelmertEnd& end = point.end;
  constexpr double kUnit = 1e-6;
  if (!end.q_mb.coeffs().allFinite() || !end.p_mb.allFinite() ||
      std::abs(end.q_mb.norm() - 1.0) > kUnit || !(std::abs(end.q_mn.norm() - 1.0) <= kUnit)) {
    throw InvalidInput(PointName(q, k) +
                       ": the pose is not finite, or its quaternion does not have unit norm");
  }
  if (!end.u_b.allFinite() || !(end.u_b.norm() > 0.0)) {
    throw InvalidInput(PointName(q, k) + ": the laser vector is zero or not finite");
  }
  for (const Vector3d& sigma : {end.sigma_ned_m, end.sigma_rph_rad}) {
    if (sigma.allFinite() && sigma.minCoeff() > 0.0) continue;
    throw InvalidInput(PointName(q, k) + ": a sigma of the trajectory is not positive and finite");
  }
  fixed_trajectory_internal::CheckLaserTerms(end.laser, laser, PointName(q, k));
}

void CheckProblem(const PlaneProblem& problem) {
  if (!problem.lever_arm_b_m.allFinite() || !problem.boresight_rad.allFinite()) {
    throw InvalidInput("the lever arm or the initial boresight is not finite");
  }
  fixed_trajectory_internal::CheckLaserUnknowns(problem.laser);
  const auto positive = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0; };
  if (problem.boresight_sigma_rad && !(problem.boresight_sigma_rad->allFinite() &&
                                       problem.boresight_sigma_rad->minCoeff() > 0.0)) {
    throw InvalidInput("the sigma of the initial boresight is not positive and finite");
  }
  if (problem.range_offset_sigma_m && !positive(*problem.range_offset_sigma_m)) {
    throw InvalidInput("the sigma of the range offset is not positive and finite");
  }
  for (std::size_t q = 0; q < problem.planes.size(); ++q) {
    const ObservedPlane& plane = problem.planes[q];
    if (!positive(plane.sigma_m)) {
      throw InvalidInput("plane " + std::to_string(q) + ": its sigma is not positive and finite");
    }
    for (std::size_t k = 0; k < plane.points.size(); ++k)
      CheckPoint(plane.points[k], problem.laser, q, k);
  }
}

/// Terms of a plane that was eliminated from the normal equations.
struct Eliminated {
  Matrix3d Q_inverse = Matrix3d::Zero();
  Eigen::Matrix<double, Eigen::Dynamic, 3> X;
  Vector3d y = Vector3d::Zero();
};

struct Sums {
  MatrixXd N;
  VectorXd g;
  double chi2 = 0.0;

  explicit Sums(Eigen::Index unknowns)
      : N(MatrixXd::Zero(unknowns, unknowns)), g(VectorXd::Zero(unknowns)) {}

  void operator+=(const Sums& other) {
    N += other.N;
    g += other.g;
    chi2 += other.chi2;
  }
};

class PlaneAdjuster {
 public:
  PlaneAdjuster(const PlaneProblem& problem, const PlaneAdjustmentOptions& options)
      : problem_(problem),
        options_(options),
        unknowns_(problem.NumUnknowns()),
        theta_(problem.boresight_rad),
        laser_(VectorXd::Zero(problem.laser.size())),
        eliminated_(problem.planes.size()) {
    result_.planes.resize(problem.planes.size());
    for (const ObservedPlane& plane : problem.planes) {
      result_.kept.emplace_back(plane.points.size(), char{1});
    }
  }

  PlaneAdjustment Run() {
    FitAll();
    Choose([this](std::size_t q) { return SeenByTwoStrips(q); });
    ExpectPlanes();
    result_.residual_initial_m = MeanResidual();
    result_.converged = Iterate();
    if (result_.converged && options_.plane_medians > 0.0) ChoosePlanes();
    if (result_.converged && options_.point_sigmas > 0.0) DropPoints();
    Finish();
    return std::move(result_);
  }

 private:
  const ObservedPlane& Plane(std::size_t q) const { return problem_.planes[q]; }
  std::size_t size() const { return problem_.planes.size(); }

  PlanePointLinearisation Linearise(std::size_t q, std::size_t k) const {
    return LinearisePlanePoint(Plane(q).points[k], Plane(q).sigma_m, problem_.lever_arm_b_m, theta_,
                               rho_m_, result_.planes[q], laser_);
  }

  /// Calls work(k) for the kept points of plane q.
  template <class Work>
  void ForPoints(std::size_t q, const Work& work) const {
    for (std::size_t k = 0; k < Plane(q).points.size(); ++k) {
      if (result_.kept[q][k] != 0) work(k);
    }
  }
  /// Calls work(q) for the selected planes.
  template <class Work>
  void ForChosen(const Work& work) const {
    for (std::size_t q = 0; q < size(); ++q) {
      if (chosen_[q] != 0) work(q);
    }
  }

  bool SeenByTwoStrips(std::size_t q) const {
    std::map<int, long> points;
    ForPoints(q, [&](std::size_t k) { ++points[Plane(q).points[k].strip]; });
    return std::count_if(points.begin(), points.end(),
                         [](const auto& of) { return of.second >= kMinStripPoints; }) >= 2;
  }

  template <class Test>
  void Choose(const Test& test) {
    chosen_.assign(size(), 0);
    for (std::size_t q = 0; q < size(); ++q) chosen_[q] = test(q) ? 1 : 0;
  }

  void ExpectPlanes() const {
    if (std::count(chosen_.begin(), chosen_.end(), 1) > 0) return;
    throw RankDeficient(
        "no plane is seen by two strips; add roofs, walls or slopes that overlapping "
        "strips share");
  }

  Vector3d PointAt(std::size_t q, std::size_t k) const {
    const GaussHelmertEnd& end = Plane(q).points[k].end;
    Vector3d u_b = end.u_b;
    if (laser_.size() > 0) u_b += VectorChange(end.laser, laser_);
    u_b -= rho_m_ * u_b.normalized();
    return end.p_mb + end.q_mb * (Exp(theta_) * u_b + problem_.lever_arm_b_m);
  }

  /// Fits a plane by total least squares at the current boresight.
  void Fit(std::size_t q) {
    Vector3d sum = Vector3d::Zero();
    double n = 0.0;
    ForPoints(q, [&](std::size_t k) {
      sum += PointAt(q, k);
      n += 1.0;
    });
    PlaneState& plane = result_.planes[q];
    if (n < static_cast<double>(kMinStripPoints)) return;
    plane.centre_m = sum / n;
    plane.d_m = 0.0;
    Matrix3d C = Matrix3d::Zero();
    ForPoints(q, [&](std::size_t k) {
      const Vector3d d = PointAt(q, k) - plane.centre_m;
      C += d * d.transpose();
    });
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(C);
    if (!(eigen.eigenvalues()[1] > kLineRatio * eigen.eigenvalues()[2])) {
      throw InvalidInput("plane " + std::to_string(q) + ": its points lie on a line");
    }
    plane.normal = eigen.eigenvectors().col(0);
    if (plane.normal.z() < 0.0) plane.normal = -plane.normal;
  }

  void FitAll() {
    ParallelForChunks(size(), kPlanesPerChunk, options_.threads,
                      [&](std::size_t, std::size_t first, std::size_t past) {
                        for (std::size_t q = first; q < past; ++q) Fit(q);
                      });
  }

  void Accumulate(std::size_t q, Sums* sums) {
    Matrix3d Q = Matrix3d::Zero();
    Eliminated& plane = eliminated_[q];
    plane.X.setZero(unknowns_, 3);
    plane.y.setZero();
    ForPoints(q, [&](std::size_t k) {
      const PlanePointLinearisation at = Linearise(q, k);
      const PlaneUnknownRow row(problem_, Plane(q).points[k], at);
      const double weight = 1.0 / at.variance_m2;
      for (std::size_t a = 0; a < row.size; ++a) {
        const double weighted = weight * row.value[a];
        for (std::size_t b = 0; b < row.size; ++b) {
          sums->N(row.at[a], row.at[b]) += weighted * row.value[b];
        }
        sums->g[row.at[a]] += weighted * at.f_m;
        plane.X.row(row.at[a]) += weighted * at.J_plane.transpose();
      }
      sums->chi2 += weight * at.f_m * at.f_m;
      Q += weight * at.J_plane * at.J_plane.transpose();
      plane.y += weight * at.f_m * at.J_plane;
    });
    plane.Q_inverse = Q.inverse();
    sums->N -= plane.X * plane.Q_inverse * plane.X.transpose();
    sums->g -= plane.X * (plane.Q_inverse * plane.y);
  }

  Sums AccumulateAll() {
    std::vector<Sums> partial(NumChunks(size(), kPlanesPerChunk), Sums(unknowns_));
    ParallelForChunks(size(), kPlanesPerChunk, options_.threads,
                      [&](std::size_t c, std::size_t first, std::size_t past) {
                        for (std::size_t q = first; q < past; ++q) {
                          if (chosen_[q] != 0) Accumulate(q, &partial[c]);
                        }
                      });
    Sums sums(unknowns_);
    for (const Sums& part : partial) sums += part;
    AddPriors(&sums);
    return sums;
  }

  void AddPriors(Sums* sums) const {
    if (problem_.boresight_sigma_rad) {
      const fixed_trajectory_internal::BoresightPrior prior =
          fixed_trajectory_internal::EvaluatePrior(problem_.boresight_rad,
                                                   *problem_.boresight_sigma_rad,
                                                   BoresightModel::kExponential, theta_);
      sums->N.topLeftCorner<3, 3>() += prior.N;
      sums->g.head<3>() += prior.g;
      sums->chi2 += prior.chi2;
    }
    if (problem_.with_range_offset && problem_.range_offset_sigma_m) {
      const double weight = 1.0 / (*problem_.range_offset_sigma_m * *problem_.range_offset_sigma_m);
      sums->N(3, 3) += weight;
      sums->g[3] += weight * rho_m_;
      sums->chi2 += weight * rho_m_ * rho_m_;
    }
    if (laser_.size() > 0) {
      const fixed_trajectory_internal::LaserPrior prior =
          fixed_trajectory_internal::EvaluateLaserPrior(problem_.laser, laser_);
      sums->N.bottomRightCorner(laser_.size(), laser_.size()) += problem_.laser.information;
      sums->g.tail(laser_.size()) += prior.g;
      sums->chi2 += prior.chi2;
    }
  }

  /// Returns the normal matrix of the boresight alone, with all other unknowns eliminated.
  Matrix3d Reduced(const MatrixXd& N) const {
    Matrix3d out = N.topLeftCorner<3, 3>();
    const Eigen::Index others = unknowns_ - 3;
    if (others == 0) return out;
    const Eigen::FullPivLU<MatrixXd> lu(N.bottomRightCorner(others, others));
    if (lu.isInvertible())
      out -= N.topRightCorner(3, others) * lu.solve(N.bottomLeftCorner(others, 3));
    return out;
  }

  static void CheckRank(const Matrix3d& N) {
    fixed_trajectory_internal::CheckBoresightRank(
        N, "planes", "add planes of other slope and aspect, or strips with other headings");
  }

  double Step() {
    const Sums sums = AccumulateAll();
    CheckRank(Reduced(sums.N));
    const VectorXd x = -sums.N.ldlt().solve(sums.g);
    const Vector3d d = x.head<3>();
    theta_ = Log(Eigen::Quaterniond(Exp(d) * Exp(theta_)));
    if (problem_.with_range_offset) rho_m_ += x[3];
    laser_ += x.tail(laser_.size());
    ForChosen([&](std::size_t q) {
      const Eliminated& plane = eliminated_[q];
      result_.planes[q] =
          Changed(result_.planes[q], -plane.Q_inverse * (plane.y + plane.X.transpose() * x));
    });
    ++result_.iterations;
    return d.norm();
  }

  bool Iterate() {
    for (int i = 0; i < options_.max_iterations; ++i) {
      if (Step() <= options_.tolerance_rad) return true;
    }
    return false;
  }

  /// Returns the root mean square of f / s of a plane fitted at the current boresight.
  double NormalisedRms(std::size_t q) const {
    double sum = 0.0, n = 0.0;
    ForPoints(q, [&](std::size_t k) {
      const PlanePointLinearisation at = Linearise(q, k);
      sum += at.f_m * at.f_m / at.variance_m2;
      n += 1.0;
    });
    return n > 0.0 ? std::sqrt(sum / n) : 0.0;
  }

  /// Keeps the planes whose rms is at most plane_medians times the median, until the selection
  /// repeats.
  void ChoosePlanes() {
    std::set<std::vector<char>> seen{chosen_};
    for (int i = 0; i < kMaxSelections && result_.converged; ++i) {
      FitAll();
      std::vector<double> rms(size(), 0.0), chosen_rms;
      for (std::size_t q = 0; q < size(); ++q) rms[q] = NormalisedRms(q);
      ForChosen([&](std::size_t q) { chosen_rms.push_back(rms[q]); });
      const double limit = options_.plane_medians * Median(chosen_rms);
      Choose([&](std::size_t q) { return SeenByTwoStrips(q) && rms[q] <= limit; });
      const bool repeats = !seen.insert(chosen_).second;
      result_.converged = Iterate();
      if (repeats) return;
    }
  }

  void DropPoints() {
    std::vector<double> sizes;
    const auto each = [&](const auto& work) {
      ForChosen([&](std::size_t q) {
        ForPoints(q, [&](std::size_t k) {
          const PlanePointLinearisation at = Linearise(q, k);
          work(q, k, std::abs(at.f_m) / std::sqrt(at.variance_m2));
        });
      });
    };
    each([&](std::size_t, std::size_t, double w) { sizes.push_back(w); });
    constexpr double kRounding = 1e-9;  // rounding error of residuals in data without noise
    const double limit =
        std::max(kRounding, options_.point_sigmas * kSigmaPerMedian * Median(std::move(sizes)));
    std::vector<std::pair<std::size_t, std::size_t>> dropped;
    each([&](std::size_t q, std::size_t k, double w) {
      if (w > limit) dropped.emplace_back(q, k);
    });
    for (const auto& [q, k] : dropped) result_.kept[q][k] = 0;
    Choose([&, before = chosen_](std::size_t q) { return before[q] != 0 && SeenByTwoStrips(q); });
    ExpectPlanes();
    result_.converged = Iterate();
  }

  double MeanResidual() const {
    double sum = 0.0, n = 0.0;
    ForChosen([&](std::size_t q) {
      ForPoints(q, [&](std::size_t k) {
        sum += std::abs(Linearise(q, k).f_m);
        n += 1.0;
      });
    });
    return sum / n;
  }

  void Count() {
    Matrix3d spread = Matrix3d::Zero();
    for (std::size_t q = 0; q < size(); ++q) {
      if (chosen_[q] == 0) {
        std::fill(result_.kept[q].begin(), result_.kept[q].end(), char{0});
        continue;
      }
      ++result_.planes_kept;
      spread += result_.planes[q].normal * result_.planes[q].normal.transpose();
      std::set<int> strips;
      ForPoints(q, [&](std::size_t k) { strips.insert(Plane(q).points[k].strip); });
      for (auto a = strips.begin(); a != strips.end(); ++a) {
        for (auto b = std::next(a); b != strips.end(); ++b) ++result_.planes_by_strips[{*a, *b}];
      }
      const long kept = std::count(result_.kept[q].begin(), result_.kept[q].end(), char{1});
      result_.points_kept += kept;
      result_.points_left_out += static_cast<long>(result_.kept[q].size()) - kept;
    }
    spread /= static_cast<double>(result_.planes_kept);
    result_.normals.eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvalues();
  }

  void Finish() {
    const Sums sums = AccumulateAll();
    Count();
    result_.boresight_rad = theta_;
    result_.range_offset_m = rho_m_;
    result_.laser = problem_.laser.start + laser_;
    result_.normal = Reduced(sums.N);
    CheckRank(result_.normal);
    result_.covariance_apriori = sums.N.inverse();
    result_.covariance_apriori_rad2 = result_.covariance_apriori.topLeftCorner<3, 3>();
    const Vector3d values = Eigen::SelfAdjointEigenSolver<Matrix3d>(result_.normal).eigenvalues();
    result_.condition_number = values[2] / values[0];
    result_.chi2 = sums.chi2;
    const long priors = (problem_.boresight_sigma_rad ? 3 : 0) +
                        (problem_.with_range_offset && problem_.range_offset_sigma_m ? 1 : 0) +
                        static_cast<long>(laser_.size());
    result_.redundancy =
        result_.points_kept + priors - static_cast<long>(unknowns_) - 3 * result_.planes_kept;
    result_.sigma0 =
        std::sqrt(result_.chi2 / static_cast<double>(std::max(1L, result_.redundancy)));
    result_.covariance_scaled_rad2 =
        result_.sigma0 * result_.sigma0 * result_.covariance_apriori_rad2;
    result_.residual_final_m = MeanResidual();
  }

  const PlaneProblem& problem_;
  const PlaneAdjustmentOptions& options_;
  const Eigen::Index unknowns_;
  Vector3d theta_;
  double rho_m_ = 0.0;
  VectorXd laser_;            // change of the laser unknowns from their start
  std::vector<char> chosen_;  // selected planes
  std::vector<Eliminated> eliminated_;
  PlaneAdjustment result_;
};

}  // namespace

void PlaneAdjustmentOptions::Validate() const {
  if (!(plane_medians == 0.0 || plane_medians > 1.0)) {
    throw InvalidConfig("plane_medians is " + std::to_string(plane_medians) +
                        ", must be 0 or above 1");
  }
  if (!(point_sigmas == 0.0 || point_sigmas > 1.0)) {
    throw InvalidConfig("point_sigmas is " + std::to_string(point_sigmas) +
                        ", must be 0 or above 1");
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

PlaneAdjustment AdjustPlanes(const PlaneProblem& problem, const PlaneAdjustmentOptions& options) {
  options.Validate();
  CheckProblem(problem);
  return PlaneAdjuster(problem, options).Run();
}

}  // namespace dn
