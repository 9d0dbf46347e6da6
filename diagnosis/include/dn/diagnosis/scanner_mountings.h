#pragma once

#include <dn/adjustment/result.h>
#include <dn/builder/flight_network.h>
#include <dn/diagnosis/model_check.h>
#include <dn/report/json.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Returns the unknown mountings of a flight with several scanners: for each scanner the boresight,
/// then the lever arm, as far as they are estimated. Empty for one scanner and without pairs.
std::vector<BlockId> MountingUnknowns(const FlightNetwork& network);

/// The boresight of one scanner.
struct ScannerBoresight {
  std::string name;
  BoresightResult boresight;
};

/// The mounting of one scanner relative to that of another.
struct RelativeMounting {
  std::string from, to;  ///< names of the scanners
  /// Rotation vector of Exp(theta_from)^-1 Exp(theta_to), total, and its covariance.
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  /// Lever arm of `to` minus that of `from`, body axes, and its covariance; absent unless both are
  /// estimated.
  std::optional<Eigen::Vector3d> lever_arm_b_m;
  Eigen::Matrix3d lever_arm_covariance_m2 = Eigen::Matrix3d::Zero();

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
  Eigen::Vector3d lever_arm_sigma_m() const {
    return lever_arm_covariance_m2.diagonal().cwiseSqrt();
  }
};

/// The mountings of all scanners of a flight.
struct ScannerMountings {
  std::vector<ScannerBoresight> scanners;  ///< those with an estimated boresight
  std::vector<RelativeMounting> relative;  ///< every two of them, from the earlier to the later
};

/// Returns the mountings of a flight with several scanners; empty for one scanner. `check` adds
/// the effects that the model leaves out, and its findings; null: the pure model. The relative
/// covariances are those of the joint posterior: errors that the scanners share cancel.
ScannerMountings ExtractMountings(const Adjustment& adjustment, const Marginals& marginals,
                                  const ModelCheck* check);

/// Returns the mountings of a design, with the covariances that the effects outside of the model
/// add (`mountings_covariance` of `effects`); uses no residuals.
ScannerMountings PredictMountings(const Adjustment& adjustment, const Marginals& marginals,
                                  const UnmodelledEffects& effects);

/// Adds `scanners` and `relative_boresight` to result.json; nothing for one scanner.
void AddScannersJson(const ScannerMountings& mountings, Json* json);

/// Adds the same to study.json: sigmas and covariances, without angles.
void AddPredictedScannersJson(const ScannerMountings& mountings, Json* json);

/// Returns lines with the boresight of each scanner and the relative mountings; empty for one
/// scanner.
std::string ScannersSummary(const ScannerMountings& mountings);

}  // namespace dn
