#include <dn/distributions.h>
#include <dn/error.h>
#include <dn/fleet/fleet.h>
#include <dn/names.h>
#include <dn/rotation.h>
#include <dn/symmetric_eigen.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "boresight_tests.h"
#include "fleet_likelihood.h"
#include "fleet_ties.h"
#include "fleet_unknowns.h"
#include "walk_size.h"

namespace dn {
namespace fleet_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

void ExpectOneMounting(const std::vector<ReducedFlight>& flights, const AcrossConfig& across) {
  const ReducedFlight& first = flights.front();
  for (const ReducedFlight& flight : flights) {
    std::string key = FindDifference(first.mounting, flight.mounting);
    const Vector3d arms = first.mounting.gnss_lever_arm_b_m - flight.mounting.gnss_lever_arm_b_m;
    if (HasName(across.unknowns, EffectName(EffectId::kGnssLeverArm)) && !arms.isZero(1e-9)) {
      key = "gnss.lever_arm_m";
    }
    if (key.empty()) continue;
    throw InvalidConfig("the flights " + first.name + " and " + flight.name + " differ in " + key +
                        ": flights of one calibration need the same scanner on the same mount");
  }
}

/// Returns the angles of a left rotation from the reference.
Vector3d Turn(const Vector3d& rotation_rad, const Vector3d& reference_rad) {
  return Log(Exp(rotation_rad) * Exp(reference_rad));
}

class FleetAdjustment {
 public:
  FleetAdjustment(const std::vector<ReducedFlight>& flights, const AcrossConfig& across)
      : flights_(flights),
        across_(across),
        shared_(FindShared(flights, across)),
        likelihood_(MakeLikelihood(flights, shared_)),
        ties_(AddTies(flights, shared_, &likelihood_)),
        last_(likelihood_.flights - 1) {
    if (ties_) result_.ties = ties_->report;
  }

  FleetResult Run() {
    result_.constant = !across_.walk_rad && !across_.walk_estimated;
    FindWalk();
    const double walk_rad = result_.constant ? 0.0 : result_.walk.sigma_rad;
    const FleetEstimate estimate(likelihood_, walk_rad);
    TakeBoresight(estimate);
    TakeUnknowns(estimate);
    TakeModelled();
    TestChanges(estimate);
    Forecast();
    AssessFleet();
    return std::move(result_);
  }

 private:
  void FindWalk() {
    result_.walk = EstimateWalk(likelihood_);
    if (!across_.walk_rad) return;
    result_.walk.sigma_rad = *across_.walk_rad;
    result_.walk.stated = true;
  }

  UncertainAngles Angles(const FleetEstimate& estimate, Index flight) const {
    const MatrixXd rows = estimate.BoresightRows(flight);
    return {Turn(rows * estimate.Mean(), likelihood_.reference_rad), estimate.Covariance(rows)};
  }

  void TakeBoresight(const FleetEstimate& estimate) {
    BoresightResult& boresight = result_.boresight;
    const UncertainAngles angles = Angles(estimate, last_);
    boresight.angles_rad = angles.rad;
    boresight.euler_zyx_rad = RollPitchHeading(Exp(angles.rad));
    boresight.covariance_rad2 = angles.covariance_rad2;
    const VectorXd values = SymmetricEigen(angles.covariance_rad2).values;
    boresight.condition_number = values[2] / values[0];
    if (shared_.size > 0) TakeShared(estimate);
  }

  /// Takes the parts of the shared effects in the covariance of the boresight.
  void TakeShared(const FleetEstimate& estimate) {
    MatrixXd rows(3 + shared_.size, likelihood_.vector.size());
    rows << estimate.BoresightRows(last_), estimate.EffectRows();
    const MatrixXd C = estimate.Covariance(rows);
    const VectorXd mean = (estimate.EffectRows() * estimate.Mean()).eval();
    const auto part = [&](Index first, Index size) {
      const MatrixXd cross = C.block(0, 3 + first, 3, size);
      const MatrixXd own = C.block(3 + first, 3 + first, size, size);
      return Matrix3d(cross * Eigen::LLT<MatrixXd>(own).solve(cross.transpose()));
    };
    result_.shared_covariance_rad2 = part(0, shared_.size);
    std::vector<EffectContribution>& all = result_.boresight.contributions;
    for (const SharedEffect& effect : shared_.effects) {
      const Index n = effect.prior_sigma.size();
      const EffectSpec& row = EffectRow(effect.effect);
      const double per_si = 1.0 / row.components.front().to_si;
      EffectContribution one{row.name, row.components.front().unit, effect.remedy, {}, {}, {}};
      one.estimate = per_si * mean.segment(effect.first, n);
      one.sigma = per_si * C.diagonal().segment(3 + effect.first, n).cwiseSqrt();
      one.prior = per_si * effect.prior_sigma;
      one.angle_sigma_rad = part(effect.first, n).diagonal().cwiseMax(0.0).cwiseSqrt();
      all.push_back(std::move(one));
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
      return a.angle_sigma_rad.maxCoeff() > b.angle_sigma_rad.maxCoeff();
    });
  }

  void TakeUnknowns(const FleetEstimate& estimate) {
    if (shared_.size == 0) return;
    const MatrixXd rows = estimate.EffectRows();
    const VectorXd mean = rows * estimate.Mean();
    const VectorXd sigma = estimate.Covariance(rows).diagonal().cwiseSqrt();
    for (const SharedEffect& effect : shared_.effects) {
      if (!effect.estimated) continue;
      const EffectSpec& row = EffectRow(effect.effect);
      UnknownEstimate unknown{row.name, row.components.front().unit, {}, {}};
      for (Index c = 0; c < effect.prior_sigma.size(); ++c) {
        unknown.value.push_back(mean[effect.first + c] / row.components.front().to_si);
        unknown.sigma.push_back(sigma[effect.first + c] / row.components.front().to_si);
      }
      result_.unknowns.push_back(std::move(unknown));
    }
  }

  /// Combines the results of the pure model, whose flights are independent but for their ties.
  void TakeModelled() {
    Matrix3d N = likelihood_.prior_information;
    Vector3d g = likelihood_.prior_vector;
    for (const ReducedFlight& flight : flights_) {
      const Matrix3d W =
          Eigen::LLT<Matrix3d>(flight.as_modelled.covariance_rad2).solve(Matrix3d::Identity());
      const Vector3d angles =
          TurnFromReference(flight.as_modelled.angles_rad, likelihood_.reference_rad);
      N += W - likelihood_.prior_information;
      g += W * angles - likelihood_.prior_vector;
    }
    if (ties_) AddModelledTies(flights_, *ties_, likelihood_.reference_rad, &N, &g);
    const Eigen::LLT<Matrix3d> llt(N);
    result_.boresight.as_modelled = ModelledBoresight{Turn(llt.solve(g), likelihood_.reference_rad),
                                                      llt.solve(Matrix3d::Identity())};
  }

  void TestChanges(const FleetEstimate& estimate) {
    const BoresightTests tests(estimate, likelihood_.flights);
    for (Index k = 0; k < likelihood_.flights; ++k) {
      const ReducedFlight& flight = flights_[static_cast<std::size_t>(k)];
      const ChangeTest test = tests.TestFlight(k);
      result_.flights.push_back({flight.name,
                                 flight.begin_s,
                                 flight.verdict,
                                 {flight.angles_rad, flight.covariance.topLeftCorner<3, 3>()},
                                 {test.change_rad, test.covariance_rad2},
                                 ChiSquareTail(test.statistic, 3.0)});
    }
    result_.stability = tests.TestAll();
    result_.stability.change.after = AfterChange(result_.stability.change);
  }

  /// Returns the boresight of the changed flights if the boresight is constant but for the change.
  UncertainAngles AfterChange(const BoresightChange& change) const {
    const auto is_changed = [&](std::size_t k) {
      return change.single_flight ? k == change.flight : k >= change.flight;
    };
    const Index old = 3 * likelihood_.flights, m = likelihood_.effects;
    MatrixXd T = MatrixXd::Zero(old + m, 6 + m);
    for (std::size_t k = 0; k < flights_.size(); ++k) {
      T.block<3, 3>(3 * static_cast<Index>(k), is_changed(k) ? 3 : 0).setIdentity();
    }
    T.bottomRightCorner(m, m).setIdentity();
    MatrixXd N = T.transpose() * likelihood_.information * T;
    N.diagonal().tail(m) += likelihood_.effect_prior;
    N.topLeftCorner<3, 3>() += likelihood_.prior_information;
    VectorXd g = T.transpose() * likelihood_.vector;
    g.head<3>() += likelihood_.prior_vector;
    const Eigen::LLT<MatrixXd> llt(N);
    const VectorXd x = llt.solve(g);
    const MatrixXd C = llt.solve(MatrixXd::Identity(N.rows(), N.cols()));
    return {Turn(x.segment<3>(3), likelihood_.reference_rad), C.block<3, 3>(3, 3)};
  }

  void Forecast() {
    result_.next_constant = Angles(FleetEstimate(likelihood_, 0.0), last_);
    const auto with_walk = [&](double walk_rad) {
      UncertainAngles angles = Angles(FleetEstimate(likelihood_, walk_rad), last_);
      angles.covariance_rad2.diagonal().array() += walk_rad * walk_rad;
      return angles;
    };
    result_.next_walk = with_walk(result_.walk.sigma_rad);
    result_.next_limit = result_.next_walk;
    if (std::isfinite(result_.walk.upper_rad)) {
      result_.next_limit = with_walk(result_.walk.upper_rad);
    } else {
      result_.next_limit.covariance_rad2.diagonal().setConstant(result_.walk.upper_rad);
    }
  }

  void AssessFleet() {
    BoresightResult& boresight = result_.boresight;
    AssessSeparability(&boresight);
    if (boresight.verdict == Verdict::kCalibrated) {
      AssessLargestSigma(boresight.sigma_rad(), &boresight);
    }
    for (const Verdict verdict : {Verdict::kAbsorbed, Verdict::kContradicted}) {
      if (std::any_of(flights_.begin(), flights_.end(),
                      [&](const ReducedFlight& flight) { return flight.verdict == verdict; })) {
        boresight.verdict = verdict;
      }
    }
    const bool apart = result_.ties && result_.ties->Contradiction() != nullptr;
    if (apart || !result_.stability.stable()) boresight.verdict = Verdict::kContradicted;
  }

  const std::vector<ReducedFlight>& flights_;
  const AcrossConfig& across_;
  SharedUnknowns shared_;
  FleetLikelihood likelihood_;
  std::optional<UsedTies> ties_;
  Index last_;
  FleetResult result_;
};

}  // namespace
}  // namespace fleet_internal

FleetResult AdjustFleet(const std::vector<ReducedFlight>& flights, const AcrossConfig& across) {
  if (flights.size() < 2) {
    throw InvalidConfig("a calibration of several flights needs two flights at least");
  }
  fleet_internal::ExpectOneMounting(flights, across);
  return fleet_internal::FleetAdjustment(flights, across).Run();
}

}  // namespace dn
