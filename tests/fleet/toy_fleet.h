#pragma once

#include <dn/fleet/fleet.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace dn::fleet_test {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Flights with linear observations y = [J L] [b; e] + noise of variance 1. b is the boresight; e
/// are effects of the sensor (scan cone, lever arm) and an effect of the day (clock).
class ToyFleet {
 public:
  static constexpr Index kRows = 30, kSensor = 4, kUnknowns = 3 + kSensor + 1;
  static constexpr double kSigma = 1e-5;  ///< typical sigma of b, rad

  explicit ToyFleet(std::uint64_t seed) : generator_(seed) {}

  double Normal() { return normal_(generator_); }
  Vector3d NormalVector() {
    return Vector3d::NullaryExpr([this] { return Normal(); });
  }

  /// Prior standard deviations of the effects: cone, lever arm, clock.
  static VectorXd PriorSigma() {
    VectorXd sigma(kSensor + 1);
    sigma << 3e-5, 0.01, 0.02, 0.01, 2e-4;
    return sigma;
  }

  /// Draws the design of a flight. The data hardly show the effects, which turn the boresight by
  /// about its own sigma.
  MatrixXd DrawDesign() {
    MatrixXd design = MatrixXd::NullaryExpr(kRows, kUnknowns, [this] { return Normal(); });
    design.leftCols<3>() *= 1.0 / (kSigma * std::sqrt(static_cast<double>(kRows)));
    const MatrixXd alike =
        design.leftCols<3>() * MatrixXd::NullaryExpr(3, kSensor + 1, [this] { return Normal(); });
    const VectorXd per_sigma = PriorSigma().cwiseInverse();
    design.rightCols<kSensor + 1>() =
        (kSigma * alike + 0.2 * design.rightCols<kSensor + 1>()) * per_sigma.asDiagonal();
    return design;
  }

  /// Draws the effects of a sensor.
  VectorXd DrawSensor() {
    VectorXd e(kSensor);
    for (double& one : e) one = Normal();
    return e.cwiseProduct(PriorSigma().head(kSensor));
  }

  /// Measures a flight with another clock.
  void Fly(const MatrixXd& design, const Vector3d& boresight_rad, const VectorXd& sensor) {
    VectorXd truth(kUnknowns);
    truth << boresight_rad, sensor, PriorSigma()[kSensor] * Normal();
    VectorXd y = design * truth;
    for (double& one : y) one += Normal();
    designs.push_back(design);
    observations.push_back(y);
    flights.push_back(Reduce(design, y, "flight " + std::to_string(flights.size() + 1)));
  }

  static ReducedFlight Reduce(const MatrixXd& design, const VectorXd& y, const std::string& name) {
    ReducedFlight flight;
    flight.name = name;
    MatrixXd N = design.transpose() * design;
    const Matrix3d pure = N.topLeftCorner<3, 3>().inverse();
    flight.as_modelled = {pure * (design.leftCols<3>().transpose() * y), pure};
    N.diagonal().tail(kSensor + 1) += PriorSigma().cwiseAbs2().cwiseInverse();
    const Eigen::LLT<MatrixXd> llt(N);
    flight.mean = llt.solve(design.transpose() * y);
    flight.covariance = llt.solve(MatrixXd::Identity(kUnknowns, kUnknowns));
    flight.effects = {{EffectId::kLidarScanCone, false, {0}, PriorSigma().head(1)},
                      {EffectId::kLidarLeverArm, false, {0, 1, 2}, PriorSigma().segment(1, 3)},
                      {EffectId::kLidarTimeOffset, false, {0}, PriorSigma().tail(1)}};
    return flight;
  }

  /// Returns the joint adjustment of all flights with one boresight, the sensor's effects and a
  /// clock per flight. The result is the mean and covariance of boresight and sensor's effects.
  /// With `walk_rad`, the boresight is that of the last flight.
  std::pair<VectorXd, MatrixXd> AdjustJointly(double walk_rad = 0.0) const {
    const auto count = static_cast<Index>(flights.size());
    const Index clocks = 3 * count, sensor = clocks + count, n = sensor + kSensor;
    MatrixXd N = MatrixXd::Zero(n, n);
    VectorXd g = VectorXd::Zero(n);
    for (Index k = 0; k < count; ++k) {
      MatrixXd A = MatrixXd::Zero(kRows, n);
      const MatrixXd& design = designs[static_cast<std::size_t>(k)];
      // The columns are boresight of the last flight, steps backwards, clocks, effects.
      A.leftCols<3>() = design.leftCols<3>();
      for (Index j = k; j + 1 < count; ++j) A.middleCols<3>(3 + 3 * j) = design.leftCols<3>();
      A.col(clocks + k) = design.col(kUnknowns - 1);
      A.rightCols(kSensor) = design.middleCols(3, kSensor);
      N += A.transpose() * A;
      g += A.transpose() * observations[static_cast<std::size_t>(k)];
    }
    const double steps = 3.0 * static_cast<double>(count - 1);
    const double step = walk_rad > 0.0 ? 1.0 / (walk_rad * walk_rad) : 1e6 / (kSigma * kSigma);
    N.diagonal().segment(3, static_cast<Index>(steps)).array() += step;
    N.diagonal().segment(clocks, count).array() += 1.0 / std::pow(PriorSigma()[kSensor], 2);
    N.diagonal().tail(kSensor) += PriorSigma().head(kSensor).cwiseAbs2().cwiseInverse();
    const Eigen::LLT<MatrixXd> llt(N);
    const VectorXd x = llt.solve(g);
    const MatrixXd C = llt.solve(MatrixXd::Identity(n, n));
    std::vector<Index> rows{0, 1, 2};
    for (Index k = 0; k < kSensor; ++k) rows.push_back(sensor + k);
    return {x(rows), C(rows, rows)};
  }

  std::vector<MatrixXd> designs;
  std::vector<VectorXd> observations;
  std::vector<ReducedFlight> flights;

 private:
  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
};

/// Returns flights alike, with one boresight.
inline ToyFleet MakeAlike(std::size_t count, std::uint64_t seed, std::uint64_t design_seed = 1) {
  ToyFleet fleet(seed), designer(design_seed);
  const MatrixXd design = designer.DrawDesign();
  const VectorXd sensor = fleet.DrawSensor();
  for (std::size_t k = 0; k < count; ++k) fleet.Fly(design, Vector3d::Zero(), sensor);
  return fleet;
}

}  // namespace dn::fleet_test
