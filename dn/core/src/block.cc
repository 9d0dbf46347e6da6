#include <dn/block.h>
#include <dn/ridders.h>

#include <Eigen/Cholesky>
#include <algorithm>

namespace dn {
namespace {

using Quat = Eigen::Map<const Eigen::Quaterniond>;
using Vec3 = Eigen::Map<const Eigen::Vector3d>;

}  // namespace

void Plus(const BlockKind& kind, const double* x, const double* d, double* x_plus_d) {
  if (kind.parametrisation == Parametrisation::kVector) {
    for (int i = 0; i < kind.stored_size; ++i) x_plus_d[i] = x[i] + d[i];
    return;
  }
  if (kind.parametrisation == Parametrisation::kManifold)
    return kind.manifold->Plus(x, d, x_plus_d);
  const Eigen::Quaterniond step = Exp(Eigen::Vector3d(Vec3(d)));
  const Eigen::Quaterniond q(x);
  const Eigen::Quaterniond result =
      kind.parametrisation == Parametrisation::kRotationRight ? q * step : step * q;
  const Eigen::Vector4d coefficients = result.normalized().coeffs();
  std::copy_n(coefficients.data(), 4, x_plus_d);
}

void Minus(const BlockKind& kind, const double* y, const double* x, double* y_minus_x) {
  if (kind.parametrisation == Parametrisation::kVector) {
    for (int i = 0; i < kind.stored_size; ++i) y_minus_x[i] = y[i] - x[i];
    return;
  }
  if (kind.parametrisation == Parametrisation::kManifold)
    return kind.manifold->Minus(y, x, y_minus_x);
  const Eigen::Quaterniond difference = kind.parametrisation == Parametrisation::kRotationRight
                                            ? Quat(x).conjugate() * Quat(y)
                                            : Quat(y) * Quat(x).conjugate();
  const Eigen::Vector3d phi = Log(difference);
  std::copy_n(phi.data(), 3, y_minus_x);
}

Eigen::Matrix<double, 4, 3> RotationPlusJacobian(Parametrisation parametrisation, const double* q) {
  const Eigen::Vector3d v(q[0], q[1], q[2]);
  const double w = q[3];
  const double s = parametrisation == Parametrisation::kRotationRight ? 1.0 : -1.0;
  Eigen::Matrix<double, 4, 3> J;
  J.topRows<3>() = 0.5 * (w * Eigen::Matrix3d::Identity() + s * Skew(v));
  J.row(3) = -0.5 * v.transpose();
  return J;
}

Eigen::MatrixXd PlusJacobian(const BlockKind& kind, const double* x) {
  if (kind.parametrisation == Parametrisation::kVector) {
    return Eigen::MatrixXd::Identity(kind.stored_size, kind.stored_size);
  }
  if (kind.parametrisation != Parametrisation::kManifold) {
    return RotationPlusJacobian(kind.parametrisation, x);
  }
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J(kind.stored_size,
                                                                           kind.tangent_size);
  kind.manifold->PlusJacobian(x, J.data());
  return J;
}

Eigen::MatrixXd MinusJacobian(const BlockKind& kind, const double* y, const double* x) {
  const Eigen::Index n = kind.tangent_size;
  if (kind.parametrisation == Parametrisation::kVector) return Eigen::MatrixXd::Identity(n, n);
  if (kind.parametrisation != Parametrisation::kManifold) {
    Eigen::Vector3d phi;
    Minus(kind, y, x, phi.data());
    return RightJacobianInverse(kind.parametrisation == Parametrisation::kRotationRight ? phi
                                                                                        : -phi);
  }
  constexpr double kFirstStep = 1e-3;
  Eigen::MatrixXd J(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto moved = [&](double step) {
      const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(n, k);
      Eigen::VectorXd to(kind.stored_size), difference(n);
      Plus(kind, y, d.data(), to.data());
      Minus(kind, to.data(), x, difference.data());
      return difference;
    };
    J.col(k) = RiddersDerivative(moved, kFirstStep).value;
  }
  return J;
}

Eigen::MatrixXd TangentLift(const BlockKind& kind, const double* x) {
  const Eigen::MatrixXd J = PlusJacobian(kind, x);
  return (J.transpose() * J).llt().solve(J.transpose());
}

}  // namespace dn
