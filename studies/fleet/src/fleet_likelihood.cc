#include "fleet_likelihood.h"

#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/symmetric_eigen.h>

#include <cmath>

namespace dn::fleet_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSamePrior = 1e-9;

/// Information, and information times mean.
struct Information {
  MatrixXd matrix;
  VectorXd vector;
};

MatrixXd Inverse(const MatrixXd& A) {
  return Eigen::LLT<MatrixXd>(A).solve(MatrixXd::Identity(A.rows(), A.cols()));
}

/// Returns the square root of the information of the prior; 0 without a prior.
double RootInformation(double sigma) { return std::isfinite(sigma) ? 1.0 / sigma : 0.0; }

/// Returns the information of the data on effects: that of their posterior minus that of their
/// prior. It is 0 in directions in which the posterior is wider than the prior, which a mixture of
/// processes can cause.
Information RemovePrior(const VectorXd& mean, const MatrixXd& covariance,
                        const VectorXd& prior_sigma) {
  if (mean.size() == 0) return {MatrixXd(0, 0), VectorXd(0)};
  const VectorXd root = prior_sigma.unaryExpr(&RootInformation);
  VectorXd unit = prior_sigma;
  for (Index k = 0; k < unit.size(); ++k) {
    if (root[k] == 0.0) unit[k] = std::sqrt(covariance(k, k));
  }
  const VectorXd per_unit = unit.cwiseInverse();
  const MatrixXd posterior = Inverse(per_unit.asDiagonal() * covariance * per_unit.asDiagonal());
  MatrixXd data = posterior;
  data.diagonal() -= root.cwiseProduct(unit).cwiseAbs2();
  const SymmetricEigen parts(data);
  const VectorXd kept = parts.values.unaryExpr([](double v) { return v > 0.0 ? 1.0 : 0.0; });
  const MatrixXd scaled = per_unit.asDiagonal() * parts.vectors;
  const VectorXd along = parts.vectors.transpose() * (posterior * per_unit.cwiseProduct(mean));
  return {scaled * parts.values.cwiseMax(0.0).asDiagonal() * scaled.transpose(),
          scaled * kept.cwiseProduct(along)};
}

/// Returns the likelihood of a flight: its unknowns are the boresight, as a left rotation from the
/// reference, and its shared effects.
Information MakeFlightLikelihood(const ReducedFlight& flight, const std::vector<SharedRow>& shared,
                                 const FleetLikelihood& fleet) {
  std::vector<Index> rows;
  VectorXd prior_sigma(static_cast<Index>(shared.size()));
  for (const SharedRow& one : shared) {
    prior_sigma[static_cast<Index>(rows.size())] = one.prior_sigma;
    rows.push_back(one.row);
  }
  const auto m = static_cast<Index>(rows.size());
  const Vector3d rotation = MeanBoresight(flight, fleet.reference_rad);
  const VectorXd mean = flight.mean(rows);
  const MatrixXd effects = flight.covariance(rows, rows);
  const Information data = RemovePrior(mean, effects, prior_sigma);
  const MatrixXd cross = flight.covariance(rows, Eigen::seqN(0, 3));
  MatrixXd response = MatrixXd::Zero(3, m);
  if (m > 0) response = (Inverse(effects) * cross).transpose();
  const Matrix3d given = flight.covariance.topLeftCorner<3, 3>() - response * cross;
  const Matrix3d W = Inverse(given);
  const Vector3d at_zero = rotation - response * mean;
  Information all{MatrixXd(3 + m, 3 + m), VectorXd(3 + m)};
  all.matrix << W - fleet.prior_information, -W * response, -response.transpose() * W,
      response.transpose() * W * response + data.matrix;
  all.vector << W * at_zero - fleet.prior_vector,
      data.vector - response.transpose() * (W * at_zero);
  return all;
}

bool ArePriorsEqual(const ReducedFlight& a, const ReducedFlight& b) {
  if (a.prior_sigma_rad.has_value() != b.prior_sigma_rad.has_value()) return false;
  if (!a.prior_sigma_rad) return true;
  return (*a.prior_sigma_rad - *b.prior_sigma_rad).norm() < kSamePrior &&
         (*a.prior_angles_rad - *b.prior_angles_rad).norm() < kSamePrior;
}

void TakeBoresightPrior(const std::vector<ReducedFlight>& flights, FleetLikelihood* fleet) {
  for (const ReducedFlight& flight : flights) {
    if (ArePriorsEqual(flight, flights.front())) continue;
    throw InvalidConfig("the flights " + flights.front().name + " and " + flight.name +
                        " state different priors of the boresight: give both the same "
                        "lidar.boresight_deg and lidar.boresight_sigma_deg");
  }
  if (!flights.front().prior_sigma_rad) return;
  const Vector3d mean = TurnFromReference(*flights.front().prior_angles_rad, fleet->reference_rad);
  fleet->prior_information =
      flights.front().prior_sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
  fleet->prior_vector = fleet->prior_information * mean;
}

}  // namespace

Vector3d TurnFromReference(const Vector3d& angles_rad, const Vector3d& reference_rad) {
  return Log(Exp(angles_rad) * Exp(Vector3d(-reference_rad)));
}

Vector3d MeanBoresight(const ReducedFlight& flight, const Vector3d& reference_rad) {
  return Log(Exp(Vector3d(flight.mean.head<3>())) * Exp(flight.angles_rad) *
             Exp(Vector3d(-reference_rad)));
}

FleetLikelihood MakeLikelihood(const std::vector<ReducedFlight>& flights,
                               const SharedUnknowns& shared) {
  FleetLikelihood fleet;
  fleet.reference_rad = flights.front().angles_rad;
  fleet.flights = static_cast<Index>(flights.size());
  fleet.effects = shared.size;
  fleet.effect_prior = shared.PriorSigma().unaryExpr(&RootInformation).cwiseAbs2();
  TakeBoresightPrior(flights, &fleet);
  const Index boresights = 3 * fleet.flights, n = boresights + shared.size;
  fleet.information = MatrixXd::Zero(n, n);
  fleet.vector = VectorXd::Zero(n);
  for (std::size_t k = 0; k < flights.size(); ++k) {
    std::vector<Index> at;
    for (Index i = 0; i < 3; ++i) at.push_back(3 * static_cast<Index>(k) + i);
    for (const SharedRow& row : shared.rows[k]) at.push_back(boresights + row.column);
    const Information one = MakeFlightLikelihood(flights[k], shared.rows[k], fleet);
    fleet.information(at, at) += one.matrix;
    fleet.vector(at) += one.vector;
  }
  return fleet;
}

FleetEstimate::FleetEstimate(const FleetLikelihood& likelihood, double walk_rad)
    : likelihood_(likelihood) {
  const Index flights = likelihood.flights, effects = likelihood.effects;
  const Index steps = walk_rad > 0.0 ? flights - 1 : 0;
  T_ = MatrixXd::Zero(3 * flights + effects, 3 + 3 * steps + effects);
  for (Index k = 0; k < flights; ++k) {
    T_.block<3, 3>(3 * k, 0).setIdentity();
    for (Index step = 0; step < std::min(k, steps); ++step) {
      T_.block<3, 3>(3 * k, 3 + 3 * step) = walk_rad * Matrix3d::Identity();
    }
  }
  T_.bottomRightCorner(effects, effects).setIdentity();
  MatrixXd N = T_.transpose() * likelihood.information * T_;
  N.topLeftCorner<3, 3>() += likelihood.prior_information;
  N.diagonal().segment(3, 3 * steps).array() += 1.0;
  N.diagonal().tail(effects) += likelihood.effect_prior;
  g_ = T_.transpose() * likelihood.vector;
  g_.head<3>() += likelihood.prior_vector;
  llt_.compute(N);
  if (llt_.info() != Eigen::Success) {
    throw RankDeficient("the flights together do not determine the unknowns that they share");
  }
  x_ = llt_.solve(g_);
}

MatrixXd FleetEstimate::Covariance(const MatrixXd& rows) const {
  const MatrixXd selected = T_.transpose() * rows.transpose();
  const MatrixXd half = llt_.matrixL().solve(selected);
  return half.transpose() * half;
}

MatrixXd FleetEstimate::BoresightRows(Index flight) const {
  MatrixXd rows = MatrixXd::Zero(3, T_.rows());
  rows.block<3, 3>(0, 3 * flight).setIdentity();
  return rows;
}

MatrixXd FleetEstimate::EffectRows() const {
  MatrixXd rows = MatrixXd::Zero(likelihood_.effects, T_.rows());
  rows.rightCols(likelihood_.effects).setIdentity();
  return rows;
}

double FleetEstimate::LogLikelihood() const {
  return 0.5 * g_.dot(x_) - llt_.matrixLLT().diagonal().array().log().sum();
}

VectorXd FleetEstimate::Score() const {
  return likelihood_.vector - likelihood_.information * (T_ * x_);
}

MatrixXd FleetEstimate::ScoreCovariance() const {
  const MatrixXd half = llt_.matrixL().solve(T_.transpose() * likelihood_.information);
  return likelihood_.information - half.transpose() * half;
}

}  // namespace dn::fleet_internal
