#include "tie_likelihood.h"

#include <map>
#include <utility>

#include "scaled_inverse.h"

namespace dn::fleet_internal {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Tie> FindTies(const std::vector<ReducedFlight>& flights) {
  struct Ends {
    std::vector<std::pair<std::size_t, Index>> first, second;  // flight, point
  };
  std::map<std::string, Ends> by_name;
  for (std::size_t flight = 0; flight < flights.size(); ++flight) {
    if (!flights[flight].ties) continue;
    const ReducedTies& ties = *flights[flight].ties;
    for (Index k = 0; k < ties.size(); ++k) {
      Ends& ends = by_name[ties.names[static_cast<std::size_t>(k)]];
      const bool is_first = ties.noise_m2[static_cast<std::size_t>(k)].has_value();
      (is_first ? ends.first : ends.second).emplace_back(flight, k);
    }
  }
  std::vector<Tie> ties;
  for (const auto& [name, ends] : by_name) {
    if (ends.first.size() != 1 || ends.second.size() != 1) continue;
    const auto& [i, at_i] = ends.first.front();
    const auto& [j, at_j] = ends.second.front();
    if (i == j) continue;
    ties.push_back(
        {name, i, j, at_i, at_j, *flights[i].ties->noise_m2[static_cast<std::size_t>(at_i)]});
  }
  return ties;
}

ConditionalTies ConditionTies(const TieMoments& ties, const VectorXd& mean,
                              const MatrixXd& covariance, const std::vector<Index>& rows) {
  const MatrixXd cross = ties.cross(Eigen::all, rows);
  ConditionalTies given;
  given.response = ScaledInverse(covariance).Solve(cross.transpose()).transpose();
  given.offset_m = ties.mean_e_m - given.response * mean;
  given.covariance_m2 = ties.covariance_m2 - given.response * cross.transpose();
  return given;
}

TieDifferences MakeDifferences(const std::vector<Tie>& ties,
                               const std::vector<ConditionalTies>& each, Index unknowns) {
  struct End {
    Index row = 0, at = 0;  // of the difference, and of the point in its flight
    double sign = 1.0;
  };
  std::vector<std::vector<End>> ends(each.size());
  for (std::size_t k = 0; k < ties.size(); ++k) {
    const Index row = 3 * static_cast<Index>(k);
    ends[ties[k].flight_i].push_back({row, 3 * ties[k].at_i, 1.0});
    ends[ties[k].flight_j].push_back({row, 3 * ties[k].at_j, -1.0});
  }
  const Index size = 3 * static_cast<Index>(ties.size());
  TieDifferences all{VectorXd::Zero(size), MatrixXd::Zero(size, unknowns),
                     MatrixXd::Zero(size, size)};
  for (std::size_t flight = 0; flight < each.size(); ++flight) {
    const ConditionalTies& given = each[flight];
    for (const End& a : ends[flight]) {
      all.offset_m.segment<3>(a.row) += a.sign * given.offset_m.segment<3>(a.at);
      all.response.middleRows<3>(a.row)(Eigen::all, given.columns) +=
          a.sign * given.response.middleRows<3>(a.at);
      for (const End& b : ends[flight]) {
        all.covariance_m2.block<3, 3>(a.row, b.row) +=
            a.sign * b.sign * given.covariance_m2.block<3, 3>(a.at, b.at);
      }
    }
  }
  return all;
}

MatrixXd NoiseCovariance(const std::vector<Tie>& ties, double factor) {
  const Index size = 3 * static_cast<Index>(ties.size());
  MatrixXd noise = MatrixXd::Zero(size, size);
  for (std::size_t k = 0; k < ties.size(); ++k) {
    const Index row = 3 * static_cast<Index>(k);
    noise.block<3, 3>(row, row) = factor * ties[k].noise_m2;
  }
  return noise;
}

TieDifferences KeepTies(const TieDifferences& all, const std::vector<std::size_t>& kept) {
  std::vector<Index> rows;
  for (const std::size_t k : kept) {
    for (Index axis = 0; axis < 3; ++axis) rows.push_back(3 * static_cast<Index>(k) + axis);
  }
  return {all.offset_m(rows), all.response(rows, Eigen::all), all.covariance_m2(rows, rows)};
}

void AddDifferences(const TieDifferences& ties, const MatrixXd& noise_m2, MatrixXd* information,
                    VectorXd* vector) {
  const ScaledInverse inverse(ties.covariance_m2 + noise_m2);
  const MatrixXd weighted = inverse.Solve(ties.response);
  *information += ties.response.transpose() * weighted;
  *vector -= weighted.transpose() * ties.offset_m;
}

}  // namespace dn::fleet_internal
