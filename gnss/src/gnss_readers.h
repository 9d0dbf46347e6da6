#pragma once

#include <dn/error.h>
#include <dn/gnss/gnss_data.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>

namespace dn::gnss_internal {

/// One reader per format; ReadGnss documents the formats and the errors.
GnssData ReadOdynGnss(const std::filesystem::path& file, double time_offset_s,
                      const GnssColumns& columns);
GnssData ReadRtklibPos(const std::filesystem::path& file, double time_offset_s);
GnssData ReadObGinsGnss(const std::filesystem::path& file, double time_offset_s,
                        const GnssColumns& columns);

GnssData ReadNmea(const std::filesystem::path& file, double time_offset_s);

/// Rotates velocity and covariances from the grid axes of `columns` to true east and north.
void TurnToTrueNorth(const GnssColumns& columns, GnssEpoch* epoch);

/// Throws InvalidInput if a component of the velocity exceeds 1e5 m/s.
void CheckVelocity(const Eigen::Vector3d& velocity_mps, const FileLocation& where);

/// Throws InvalidInput unless every standard deviation lies between 1e-9 and 1e9 (m or m/s). The
/// message names it by `what` ("position", "velocity") and by its letter in `axes` ("ENU").
void CheckSigmas(const Eigen::Vector3d& sigma, const std::string& what, const std::string& axes,
                 const FileLocation& where);

/// Returns diag(sigma^2) after CheckSigmas for the axes east, north, up.
Eigen::Matrix3d EnuSigmasToCovariance(const Eigen::Vector3d& sigma_enu, const std::string& what,
                                      const FileLocation& where);

/// Returns the rotation from the local east-north-up axes at a point to ECEF.
Eigen::Matrix3d R_e_enu(const Geodetic& point);

/// Returns the covariance matrix with standard deviations `sigma`. The covariances c of the pairs
/// 01, 12, 20 are given as signed roots sign(c) sqrt|c|. If rounding or the writing program left
/// the matrix indefinite, it becomes positive definite by shrinking the correlations; the standard
/// deviations stay.
Eigen::Matrix3d SignedRootsToCovariance(const Eigen::Vector3d& sigma,
                                        const Eigen::Vector3d& signed_roots);

}  // namespace dn::gnss_internal
