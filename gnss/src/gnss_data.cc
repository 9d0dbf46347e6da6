#include <dn/geo/text_table.h>
#include <dn/gnss/gnss_data.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gnss_readers.h"

namespace dn {
namespace gnss_internal {
namespace {

/// Standard deviations in m or m/s outside this interval must be another quantity.
constexpr double kLeastSigma = 1e-9, kMostSigma = 1e9;

}  // namespace

void CheckSigmas(const Eigen::Vector3d& sigma, const std::string& what, const std::string& axes,
                 const FileLocation& where) {
  for (int i = 0; i < 3; ++i) {
    const double value = sigma[i];
    if (value >= kLeastSigma && value <= kMostSigma) continue;
    std::string text = what + " sigma ";
    text += axes[static_cast<std::size_t>(i)];
    text += " is ";
    text += value == 0.0 ? "zero" : value < 0.0 ? "negative" : FormatDouble(value);
    text += ", must lie between 1e-9 and 1e9; omit the sigma columns if the sigma is unknown";
    throw InvalidInput(text, where);
  }
}

void CheckVelocity(const Eigen::Vector3d& velocity_mps, const FileLocation& where) {
  constexpr double kMostMps = 1e5;
  const double largest = velocity_mps.cwiseAbs().maxCoeff();
  if (largest <= kMostMps) return;
  throw InvalidInput("velocity is " + FormatDouble(largest) + " m/s, must be below 1e5", where);
}

Eigen::Matrix3d EnuSigmasToCovariance(const Eigen::Vector3d& sigma_enu, const std::string& what,
                                      const FileLocation& where) {
  CheckSigmas(sigma_enu, what, "ENU", where);
  return sigma_enu.cwiseAbs2().asDiagonal();
}

void TurnToTrueNorth(const GnssColumns& columns, GnssEpoch* epoch) {
  if (!columns.grid_north) return;
  const double azimuth_rad = columns.position.Convergence_rad(epoch->antenna);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(-azimuth_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const auto turn = [&R](std::optional<Eigen::Matrix3d>* covariance) {
    if (*covariance) *covariance = R * **covariance * R.transpose();
  };
  turn(&epoch->covariance_enu_m2);
  turn(&epoch->velocity_covariance_enu);
  if (epoch->velocity_enu_mps) epoch->velocity_enu_mps = R * *epoch->velocity_enu_mps;
}

Eigen::Matrix3d R_e_enu(const Geodetic& point) {
  const Eigen::Matrix3d ned = R_en(point);
  Eigen::Matrix3d enu;
  enu << ned.col(1), ned.col(0), -ned.col(2);
  return enu;
}

Eigen::Matrix3d SignedRootsToCovariance(const Eigen::Vector3d& sigma,
                                        const Eigen::Vector3d& signed_roots) {
  constexpr double kMinEigenvalue = 1e-3;  // of the correlation matrix
  const Eigen::Vector3d c = signed_roots.cwiseProduct(signed_roots.cwiseAbs());
  Eigen::Matrix3d covariance;
  covariance << 0.0, c[0], c[2], c[0], 0.0, c[1], c[2], c[1], 0.0;
  const Eigen::Matrix3d D = sigma.asDiagonal();
  const Eigen::Matrix3d D_inverse = sigma.cwiseInverse().asDiagonal();
  Eigen::Matrix3d correlation = D_inverse * covariance * D_inverse;
  correlation.diagonal().setOnes();
  const double smallest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(correlation, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  if (smallest < kMinEigenvalue) {
    const double keep = (1.0 - kMinEigenvalue) / (1.0 - smallest);
    correlation = keep * correlation + (1.0 - keep) * Eigen::Matrix3d::Identity();
  }
  return D * correlation * D;
}

}  // namespace gnss_internal

namespace {

/// Leaves out the epochs without a covariance if other epochs have one.
void LeaveOutUnknownSigmas(GnssData* data) {
  const auto unknown = [](const GnssEpoch& epoch) { return !epoch.covariance_enu_m2; };
  std::vector<GnssEpoch>& epochs = data->epochs;
  if (std::all_of(epochs.begin(), epochs.end(), unknown)) return;
  data->Count("gnss rows with sigmas of 0, left out",
              static_cast<long>(std::erase_if(epochs, unknown)));
}

GnssData ReadFormat(const std::filesystem::path& file, GnssFormat format, double time_offset_s,
                    const GnssColumns& columns) {
  switch (format) {
    case GnssFormat::kOdyn:
      return gnss_internal::ReadOdynGnss(file, time_offset_s, columns);
    case GnssFormat::kRtklib:
      return gnss_internal::ReadRtklibPos(file, time_offset_s);
    case GnssFormat::kObGins:
      return gnss_internal::ReadObGinsGnss(file, time_offset_s, columns);
    case GnssFormat::kNmea:
      return gnss_internal::ReadNmea(file, time_offset_s);
  }
  throw InvalidInput("unknown GNSS format", {file.string(), 0, 0});
}

}  // namespace

const std::vector<std::string>& GnssQuantities() {
  static const std::vector<std::string> quantities{"lat",     "lon",      "h",        "sigma_e",
                                                   "sigma_n", "sigma_u",  "ve",       "vn",
                                                   "vu",      "sigma_ve", "sigma_vn", "sigma_vu"};
  return quantities;
}

GnssData ReadGnss(const std::filesystem::path& file, GnssFormat format, double time_offset_s,
                  const GnssColumns& columns) {
  GnssData data = ReadFormat(file, format, time_offset_s, columns);
  LeaveOutUnknownSigmas(&data);
  return data;
}

}  // namespace dn
