#include "weak_directions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace dn {
namespace {

constexpr double kListedWeight = 0.2;
// Limit at which the variances along a direction are ten times those of separate unknowns.
constexpr double kWeakInformation = 0.1;
constexpr double kCalibrationShare = 0.1;  // smallest squared weight of the calibration unknowns
constexpr std::size_t kMostDirections = 4;

/// Returns the inverse. It is computed from the correlations, because the unknowns differ in size
/// by orders of magnitude.
Eigen::MatrixXd Inverse(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::MatrixXd identity =
      Eigen::MatrixXd::Identity(correlation.rows(), correlation.cols());
  return scale.asDiagonal() * correlation.ldlt().solve(identity) * scale.asDiagonal();
}

class Directions {
 public:
  explicit Directions(const JointCovariance& joint)
      : joint_(joint), normal_(Inverse(joint.covariance)) {}

  /// Returns the direction with these weights, one per unknown. The largest weight becomes
  /// positive.
  StudyDirection MakeDirection(const Eigen::VectorXd& weights) const {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(weights.size()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
      return std::abs(weights[a]) > std::abs(weights[b]);
    });
    const double sign = weights[order.front()] < 0.0 ? -1.0 : 1.0;
    StudyDirection direction;
    for (const Eigen::Index i : order) {
      if (std::abs(weights[i]) >= kListedWeight) {
        direction.unknowns.emplace_back(Unknown(i).name, sign * weights[i]);
      }
    }
    const auto leading = std::find_if(order.begin(), order.end(),
                                      [&](Eigen::Index i) { return Unknown(i).calibration; });
    FillLeading(*leading, &direction);
    return direction;
  }

  /// Returns the weights of the weakest direction of the boresight, which has the first three
  /// unknowns.
  Eigen::VectorXd WeakestBoresightWeights() const {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
        joint_.covariance.topLeftCorner<3, 3>());
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(joint_.covariance.rows());
    weights.head<3>() = eigen.eigenvectors().col(2);
    return weights;
  }

  /// Returns the weights of the directions that are weak because their unknowns cannot be
  /// separated.
  std::vector<Eigen::VectorXd> Coupled() const {
    const Eigen::VectorXd scale = normal_.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * normal_ *
                                                               scale.asDiagonal());
    std::vector<Eigen::VectorXd> weak;
    for (Eigen::Index k = 0; k < scale.size(); ++k) {
      const Eigen::VectorXd weights = eigen.eigenvectors().col(k);
      if (eigen.eigenvalues()[k] < kWeakInformation && HasCalibration(weights)) {
        weak.push_back(weights);
      }
    }
    return weak;
  }

 private:
  const JointUnknown& Unknown(Eigen::Index i) const {
    return joint_.unknowns[static_cast<std::size_t>(i)];
  }

  bool HasCalibration(const Eigen::VectorXd& weights) const {
    double share = 0.0;
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      if (Unknown(i).calibration) share += weights[i] * weights[i];
    }
    return share > kCalibrationShare;
  }

  void FillLeading(Eigen::Index i, StudyDirection* direction) const {
    direction->leading = Unknown(i).name;
    direction->unit = Unknown(i).unit;
    direction->sigma = joint_.sigma(i) * Unknown(i).per_si;
    const double alone = 1.0 / (normal_(i, i) * joint_.covariance(i, i));
    direction->correlation = std::sqrt(std::clamp(1.0 - alone, 0.0, 1.0));
  }

  const JointCovariance& joint_;
  Eigen::MatrixXd normal_;
};

}  // namespace

std::vector<StudyDirection> StudyDirections(const JointCovariance& joint) {
  const Directions directions(joint);
  std::vector<StudyDirection> found{directions.MakeDirection(directions.WeakestBoresightWeights())};
  for (const Eigen::VectorXd& weights : directions.Coupled()) {
    if (found.size() == kMostDirections) break;
    found.push_back(directions.MakeDirection(weights));
  }
  return found;
}

}  // namespace dn
