#include <dn/builder/gravitation_jacobians.h>

namespace dn {

std::vector<GravitationBasis> GravitationJacobians(const CalibrationState& calibration,
                                                   const Eigen::Vector3d& p_m) {
  std::vector<GravitationBasis> bases;
  ForEachEffect<GravitationField>(
      calibration, [&](const GravitationField& field, const Eigen::VectorXd&, std::size_t) {
        bases.push_back(field(p_m));
      });
  return bases;
}

}  // namespace dn
