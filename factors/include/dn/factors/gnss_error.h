#pragma once

#include <dn/factors/gnss_antenna.h>
#include <dn/gnss/gnss_process.h>

#include <Eigen/Core>

namespace dn {

/// An error of GNSS positions that lasts, as a state: the block of a GnssAntenna that is the value
/// of a process at the epoch,
///
///   shift_m = R_m_enu diag(sigma_enu) c,      c [3]: east, north, up, in units of the sigmas.
///
/// c has unit variance whatever the sigmas are, so that an axis whose sigma is zero has no error, and
/// its state none but its own process.
class GnssError final : public GnssEffect {
 public:
  /// R_m_enu: local east-north-up of the antenna to map. Throws InvalidInput unless the sigmas are
  /// finite and not negative.
  GnssError(const GnssProcess& process, const Eigen::Matrix3d& R_m_enu);

  int components() const override { return 3; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override;

 private:
  Eigen::Matrix3d shift_m_;  // per unit of c
};

}  // namespace dn
