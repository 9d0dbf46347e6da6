// Exchanges a quaternion between a program and the library.
#include <dn/rotation.h>

#include <cmath>

int main() {
  const Eigen::Vector3d rph_rad(0.1, 0.2, 0.3);
  const Eigen::Vector3d back_rad =
      dn::RollPitchHeading(dn::QuaternionFromRollPitchHeading(rph_rad));
  return (back_rad - rph_rad).norm() < 1e-12 ? 0 : 1;
}
