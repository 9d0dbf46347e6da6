#include "fleet_ties.h"

#include <dn/geo/local_frame.h>

#include <utility>

#include "scaled_inverse.h"
#include "tie_screening.h"

namespace dn {
namespace fleet_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Conditions the ties of each flight on its boresight and its shared effects.
std::vector<ConditionalTies> ConditionFlights(const std::vector<ReducedFlight>& flights,
                                              const SharedUnknowns& shared,
                                              const FleetLikelihood& likelihood) {
  std::vector<ConditionalTies> each;
  for (std::size_t k = 0; k < flights.size(); ++k) {
    each.emplace_back();
    if (!flights[k].ties) continue;
    std::vector<Index> rows{0, 1, 2}, columns;
    for (Index axis = 0; axis < 3; ++axis) columns.push_back(3 * static_cast<Index>(k) + axis);
    for (const SharedRow& row : shared.rows[k]) {
      rows.push_back(row.row);
      columns.push_back(3 * likelihood.flights + row.column);
    }
    VectorXd mean = flights[k].mean(rows);
    mean.head<3>() = MeanBoresight(flights[k], likelihood.reference_rad);
    each.back() =
        ConditionTies(flights[k].ties->moments, mean, flights[k].covariance(rows, rows), rows);
    each.back().columns = std::move(columns);
  }
  return each;
}

/// Returns the information on all unknowns if each flight has a boresight of its own.
MatrixXd SingleFlightInformation(const FleetLikelihood& likelihood) {
  MatrixXd information = likelihood.information;
  information.diagonal().tail(likelihood.effects) += likelihood.effect_prior;
  for (Index k = 0; k < likelihood.flights; ++k) {
    information.block<3, 3>(3 * k, 3 * k) += likelihood.prior_information;
  }
  return information;
}

}  // namespace

std::optional<UsedTies> AddTies(const std::vector<ReducedFlight>& flights,
                                const SharedUnknowns& shared, FleetLikelihood* likelihood) {
  const std::vector<Tie> ties = FindTies(flights);
  if (ties.empty()) return std::nullopt;
  const TieDifferences differences = MakeDifferences(
      ties, ConditionFlights(flights, shared, *likelihood), likelihood->vector.size());
  const ScaledInverse alone(SingleFlightInformation(*likelihood));
  VectorXd vector = likelihood->vector;
  for (Index k = 0; k < likelihood->flights; ++k) {
    vector.segment<3>(3 * k) += likelihood->prior_vector;
  }
  const Matrix3d R_enu_e = LocalFrame(flights.front().origin).R_me();
  const ScreenedTies screened =
      ScreenTies(ties, differences, alone.Solve(vector), alone.Matrix(), R_enu_e, flights);
  UsedTies used{{}, {screened.by_strips, screened.noise_factor}};
  for (const std::size_t k : screened.kept) used.ties.push_back(ties[k]);
  if (used.ties.empty()) return used;
  AddDifferences(KeepTies(differences, screened.kept),
                 NoiseCovariance(used.ties, screened.noise_factor), &likelihood->information,
                 &likelihood->vector);
  return used;
}

void AddModelledTies(const std::vector<ReducedFlight>& flights, const UsedTies& used,
                     const Vector3d& reference_rad, Matrix3d* N, Vector3d* g) {
  if (used.ties.empty()) return;
  std::vector<ConditionalTies> each;
  for (const ReducedFlight& flight : flights) {
    each.emplace_back();
    if (!flight.ties) continue;
    const Vector3d mean = TurnFromReference(flight.as_modelled.angles_rad, reference_rad);
    each.back() = ConditionTies(flight.ties->as_modelled, mean, flight.as_modelled.covariance_rad2,
                                {0, 1, 2});
    each.back().columns = {0, 1, 2};
  }
  MatrixXd information = *N;
  VectorXd vector = *g;
  AddDifferences(MakeDifferences(used.ties, each, 3),
                 NoiseCovariance(used.ties, used.report.noise_factor), &information, &vector);
  *N = information;
  *g = vector;
}

}  // namespace fleet_internal

long FleetTies::used() const {
  long sum = 0;
  for (const StripTies& strips : by_strips) sum += strips.used;
  return sum;
}

const StripTies* FleetTies::Contradiction() const {
  const StripTies* worst = nullptr;
  for (const StripTies& strips : by_strips) {
    if (strips.p_value > kLevel) continue;
    if (worst == nullptr || strips.p_value < worst->p_value) worst = &strips;
  }
  return worst;
}

}  // namespace dn
