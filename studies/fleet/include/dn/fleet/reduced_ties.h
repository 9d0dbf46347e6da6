#pragma once

#include <dn/adjustment/result.h>
#include <dn/diagnosis/effect_posterior.h>
#include <dn/eigen_alignment.h>
#include <dn/report/json_reader.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

class Solution;

/// Positions of tie points in ECEF, three numbers per point, with their covariances.
struct TieMoments {
  Eigen::VectorXd mean_e_m;
  Eigen::MatrixXd covariance_m2;
  Eigen::MatrixXd cross;  ///< covariance of the positions (rows) with other unknowns (columns), SI
};

/// Ground points that a flight and others measured, as the flight determines them.
struct ReducedTies {
  std::vector<std::string> names;  ///< of the pairs, the same in both flights
  TieMoments moments;              ///< `cross`: with the unknowns of ReducedFlight::mean
  TieMoments as_modelled;          ///< by the pure model; `cross`: with the boresight
  /// Covariance of the noise of each pair, the first point minus the second, ECEF, m^2; nullopt
  /// for pairs whose second end the flight measured.
  std::vector<std::optional<Eigen::Matrix3d>> noise_m2;

  Eigen::Index size() const { return static_cast<Eigen::Index>(names.size()); }
};

/// Returns the tie points of an adjusted flight; nullopt if it has none. `unknowns` are the
/// boresight and the effects under `estimate`, `rows` their rows in the unknowns of `posterior`;
/// that is null for the pure model.
std::optional<ReducedTies> ReduceTies(const Solution& solution,
                                      const std::vector<BlockId>& unknowns,
                                      const std::vector<Eigen::Index>& rows,
                                      const EffectPosterior* posterior);

/// Returns the tie points as a part of reduced.json, with nine digits per covariance.
Json ReducedTiesJson(const ReducedTies& ties);
/// Reads them. `unknowns`: the size of ReducedFlight::mean. Throws InvalidInput if it does not
/// describe tie points.
ReducedTies ReadReducedTies(const JsonPlace& json, Eigen::Index unknowns);

}  // namespace dn
