#pragma once

#include <dn/error.h>
#include <dn/gnss/gnss_data.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>

namespace dn::internal {

/// See ReadGnss; one function per format.
GnssData ReadOdynGnss(const std::filesystem::path& file, double time_offset_s,
                      const GnssColumns& columns);
GnssData ReadRtklibPos(const std::filesystem::path& file, double time_offset_s);
GnssData ReadObGinsGnss(const std::filesystem::path& file, double time_offset_s,
                        const GnssColumns& columns);

GnssData ReadNmea(const std::filesystem::path& file, double time_offset_s);

/// Turns velocity and covariances from the grid of the columns to true east and north.
void TurnToTrueNorth(const GnssColumns& columns, GnssEpoch* epoch);

/// Throws InvalidInput for a velocity that nothing flies at.
void CheckVelocity(const Eigen::Vector3d& velocity_mps, const FileLocation& where);

/// Checks that standard deviations lie within 1e-9 and 1e9 (m or m/s); `what` ("position",
/// "velocity") and `axes` ("ENU") name them in the message.
void CheckSigmas(const Eigen::Vector3d& sigma, const std::string& what, const std::string& axes,
                 const FileLocation& where);

/// diag(sigma^2), after CheckSigmas with the axes east, north, up.
Eigen::Matrix3d CovarianceOfSigmasEnu(const Eigen::Vector3d& sigma_enu, const std::string& what,
                                      const FileLocation& where);

/// Rotation from the local east-north-up of a point to ECEF.
Eigen::Matrix3d R_e_enu(const Geodetic& point);

/// The covariance with the given standard deviations and with the covariances whose signed roots
/// (sign(c) sqrt|c|) of the pairs 01, 12, 20 are given, made positive definite where rounding or
/// the writer left it indefinite: correlations are shrunk, standard deviations kept.
Eigen::Matrix3d CovarianceOfSignedRoots(const Eigen::Vector3d& sigma,
                                        const Eigen::Vector3d& signed_roots);

}  // namespace dn::internal
