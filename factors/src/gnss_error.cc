#include <dn/error.h>
#include <dn/factors/gnss_error.h>

namespace dn {

CorrelatedGnssError::CorrelatedGnssError(const GnssProcess& process, const Eigen::Matrix3d& R_m_enu)
    : shift_m_(R_m_enu * process.sigma_enu_m.asDiagonal()) {
  if (!shift_m_.allFinite() || process.sigma_enu_m.minCoeff() < 0.0) {
    throw InvalidInput("sigmas of a process of GNSS errors must be finite and not negative");
  }
}

void CorrelatedGnssError::Correct(const Eigen::Ref<const Eigen::VectorXd>& value,
                                  Eigen::Index column, GnssReading* reading) const {
  reading->shift_m += shift_m_ * value;
  reading->J_shift.middleCols<3>(column) = shift_m_;
}

}  // namespace dn
