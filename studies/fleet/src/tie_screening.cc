#include "tie_screening.h"

#include <dn/distributions.h>
#include <dn/median.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "scaled_inverse.h"

namespace dn::fleet_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kOutlierProbability = 0.01;  // of a good tie to be the worst outlier
constexpr double kSameNoise = 1.02;
// The median of n normalised squares exceeds that of chi-square(3) by this share over sqrt(n) with
// a probability of 1 %. Its standard deviation is 1 / (2 f sqrt(n)), with the density f.
constexpr double kMedianQuantile = 2.6;
constexpr int kMostNoiseSteps = 8;

/// Differences with their whole covariance S. Each tie is predicted from all others:
///
///   residual = Q_kk^-1 (Q d)_k,   covariance = Q_kk^-1,   Q = S^-1.
class Predictions {
 public:
  Predictions(const VectorXd& d_m, const MatrixXd& covariance_m2)
      : Q_(ScaledInverse(covariance_m2).Matrix()), q_(Q_ * d_m) {
    present_.assign(static_cast<std::size_t>(d_m.size() / 3), true);
  }

  bool IsPresent(std::size_t k) const { return present_[k]; }

  /// Returns the squared residual of a tie in units of its covariance: chi-square(3).
  double Statistic(std::size_t k) const {
    const Index row = 3 * static_cast<Index>(k);
    const Vector3d q = q_.segment<3>(row);
    return q.dot(Matrix3d(Q_.block<3, 3>(row, row)).llt().solve(q));
  }

  std::vector<double> Statistics() const {
    std::vector<double> all;
    for (std::size_t k = 0; k < present_.size(); ++k) {
      if (present_[k]) all.push_back(Statistic(k));
    }
    return all;
  }

  void Remove(std::size_t k) {
    const Index row = 3 * static_cast<Index>(k);
    const Matrix3d inverse = Matrix3d(Q_.block<3, 3>(row, row)).inverse();
    const MatrixXd gain = Q_.middleCols<3>(row) * inverse;
    q_ -= gain * q_.segment<3>(row).eval();
    Q_ -= gain * Q_.middleRows<3>(row).eval();
    present_[k] = false;
  }

 private:
  MatrixXd Q_;
  VectorXd q_;
  std::vector<bool> present_;
};

class Screening {
 public:
  Screening(const std::vector<Tie>& ties, const TieDifferences& differences, const VectorXd& mean,
            const MatrixXd& covariance)
      : ties_(ties),
        d_m_(differences.offset_m + differences.response * mean),
        without_noise_m2_(differences.covariance_m2 +
                          differences.response * covariance * differences.response.transpose()) {}

  ScreenedTies Run() {
    Predictions predictions = FindNoise();
    RemoveOutliers(&predictions);
    for (std::size_t k = 0; k < ties_.size(); ++k) {
      if (predictions.IsPresent(k)) found_.kept.push_back(k);
    }
    return found_;
  }

  const VectorXd& d_m() const { return d_m_; }
  MatrixXd Covariance() const {
    return without_noise_m2_ + NoiseCovariance(ties_, found_.noise_factor);
  }

 private:
  Predictions FindNoise() {
    const double median = ChiSquareQuantile(0.5, 3.0);
    const double by_chance = 1.0 + kMedianQuantile / std::sqrt(static_cast<double>(ties_.size()));
    for (int step = 0;; ++step) {
      Predictions predictions(d_m_, Covariance());
      const double ratio = Median(predictions.Statistics()) / median;
      const double same = found_.noise_factor > 1.0 ? kSameNoise : by_chance;
      if (ratio < same || step == kMostNoiseSteps) return predictions;
      found_.noise_factor *= ratio;
    }
  }

  void RemoveOutliers(Predictions* predictions) const {
    const double limit =
        ChiSquareQuantile(1.0 - kOutlierProbability / static_cast<double>(ties_.size()), 3.0);
    for (;;) {
      std::size_t worst = 0;
      double largest = 0.0;
      for (std::size_t k = 0; k < ties_.size(); ++k) {
        if (!predictions->IsPresent(k)) continue;
        const double statistic = predictions->Statistic(k);
        if (statistic > largest) {
          largest = statistic;
          worst = k;
        }
      }
      if (largest <= limit) return;
      predictions->Remove(worst);
    }
  }

  const std::vector<Tie>& ties_;
  VectorXd d_m_;
  MatrixXd without_noise_m2_;
  ScreenedTies found_;
};

/// Returns the mean of some differences with its covariance.
std::pair<Vector3d, Matrix3d> MeanDifference(const std::vector<std::size_t>& ties,
                                             const VectorXd& d_m, const MatrixXd& covariance_m2) {
  const double share = 1.0 / static_cast<double>(ties.size());
  Vector3d mean_m = Vector3d::Zero();
  Matrix3d C_m2 = Matrix3d::Zero();
  for (const std::size_t a : ties) {
    mean_m += share * d_m.segment<3>(3 * static_cast<Index>(a));
    for (const std::size_t b : ties) {
      C_m2 += share * share *
              covariance_m2.block<3, 3>(3 * static_cast<Index>(a), 3 * static_cast<Index>(b));
    }
  }
  return {mean_m, C_m2};
}

/// Returns FOLDER/FILE of a tie.
std::string PairFile(const std::string& name) { return name.substr(0, name.rfind(':')); }

}  // namespace

ScreenedTies ScreenTies(const std::vector<Tie>& ties, const TieDifferences& differences,
                        const VectorXd& mean, const MatrixXd& covariance, const Matrix3d& R_enu_e,
                        const std::vector<ReducedFlight>& flights) {
  Screening screening(ties, differences, mean, covariance);
  ScreenedTies found = screening.Run();
  const MatrixXd covariance_m2 = screening.Covariance();
  std::map<std::string, std::vector<std::size_t>> kept, all;
  for (std::size_t k = 0; k < ties.size(); ++k) all[PairFile(ties[k].name)].push_back(k);
  for (const std::size_t k : found.kept) kept[PairFile(ties[k].name)].push_back(k);
  for (const auto& [file, some] : all) {
    const Tie& tie = ties[some.front()];
    StripTies strips{file, flights[tie.flight_i].name, flights[tie.flight_j].name};
    strips.used = static_cast<long>(kept[file].size());
    strips.rejected = static_cast<long>(some.size()) - strips.used;
    // Strips whose ties all disagree are compared by all of them.
    const auto [d_m, C_m2] =
        MeanDifference(strips.used > 0 ? kept[file] : some, screening.d_m(), covariance_m2);
    strips.mean_enu_m = R_enu_e * d_m;
    strips.sigma_enu_m = (R_enu_e * C_m2 * R_enu_e.transpose()).diagonal().cwiseSqrt();
    strips.p_value = std::min(
        1.0, static_cast<double>(all.size()) * ChiSquareTail(d_m.dot(C_m2.llt().solve(d_m)), 3.0));
    found.by_strips.push_back(std::move(strips));
  }
  return found;
}

}  // namespace dn::fleet_internal
