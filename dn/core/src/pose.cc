#include <dn/pose.h>

namespace dn {

void Pose::Plus(const double* x, const double* d, double* x_plus_d) {
  dn::Plus(Rotation::kKind, x, d, x_plus_d);
  for (int i = 0; i < 3; ++i) x_plus_d[4 + i] = x[4 + i] + d[3 + i];
}

void Pose::Minus(const double* y, const double* x, double* y_minus_x) {
  dn::Minus(Rotation::kKind, y, x, y_minus_x);
  for (int i = 0; i < 3; ++i) y_minus_x[3 + i] = y[4 + i] - x[4 + i];
}

void Pose::PlusJacobian(const double* x, double* J) {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> out(J);
  out.setZero();
  out.topLeftCorner<4, 3>() = RotationPlusJacobian(Parametrisation::kRotationRight, x);
  out.bottomRightCorner<3, 3>().setIdentity();
}

}  // namespace dn
