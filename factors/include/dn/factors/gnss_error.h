#pragma once

#include <dn/factors/gnss_antenna.h>
#include <dn/gnss/gnss_process.h>

#include <Eigen/Core>

namespace dn {

/// A time-correlated error of GNSS positions as a state: a block of a GnssAntenna with the value c
/// of a process at the epoch,
///
///   shift_m = R_m_enu diag(sigma_enu) c,      c [3]: east, north, up, in units of the sigmas.
///
/// c has unit variance whatever the sigmas are. An axis with sigma zero therefore has no error, and
/// its state is determined by the process alone.
class CorrelatedGnssError final : public GnssEffect {
 public:
  /// Creates the effect; R_m_enu rotates from the local east-north-up frame of the antenna to map.
  /// Throws InvalidInput unless the sigmas are finite and not negative.
  CorrelatedGnssError(const GnssProcess& process, const Eigen::Matrix3d& R_m_enu);

  int components() const override { return 3; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override;

 private:
  Eigen::Matrix3d shift_m_;  // shift per unit of c
};

}  // namespace dn
