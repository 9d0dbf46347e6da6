#include <dn/error.h>
#include <dn/factors/point_to_point.h>
#include <dn/rotation.h>

#include <cmath>

namespace dn {
PointToPoint::PointToPoint(const LocalFrame& frame, const PreparedPair& pair)
    : u_i_b_(pair.R_bs_nominal * pair.i.u_s),
      u_j_b_(pair.R_bs_nominal * pair.j.u_s),
      dt_nominal_s_(pair.dt_nominal_s),
      W_(pair.noise_m.sqrt_information()) {
  if (!std::isfinite(pair.dt_nominal_s)) {
    throw InvalidInput("point pair: the nominal time offset is not finite");
  }
  factors_internal::CheckPreparedPair(pair);
  if (pair.R_bs_nominal_j) {
    throw InvalidInput("point pair: the ends of two scanners need the blocks of both mountings");
  }
  if (pair.i.bridge || pair.j.bridge) {
    throw InvalidInput("point pair: an end with a bridge needs the blocks of the node after it");
  }
  i_ = LidarPoint(frame, pair.i.partial, pair.i.p_nominal_m);
  j_ = LidarPoint(frame, pair.j.partial, pair.j.p_nominal_m);
}

LidarPoint::Arguments PointToPoint::Arguments(double const* const* node, const Eigen::Vector3d& u_b,
                                              double const* const* x) const {
  using Vec3 = Eigen::Map<const Eigen::Vector3d>;
  return {Eigen::Quaterniond(node[0]), Vec3(node[1]), Vec3(node[2]),
          Eigen::Quaterniond(x[6]),    Vec3(x[7]),    u_b,
          x[8][0] - dt_nominal_s_};
}

bool PointToPoint::Evaluate(double const* const* x, double* r, double** J) const {
  const LidarPoint::Derivatives i = i_.DifferentiateAt(Arguments(x, u_i_b_, x));
  const LidarPoint::Derivatives j = j_.DifferentiateAt(Arguments(x + 3, u_j_b_, x));
  const double ddt = x[8][0] - dt_nominal_s_;
  const Eigen::Vector3d difference = (i.x - j.x) - ddt * (i.rate - j.rate);
  Eigen::Map<Eigen::Vector3d> out(r);
  out.noalias() = W_ * difference;

  Put<0>(x, J, Eigen::Matrix3d(W_ * i.q));
  Put<1>(x, J, Eigen::Matrix3d(W_ * i.p));
  Put<2>(x, J, Eigen::Matrix3d(W_ * i.v));
  Put<3>(x, J, Eigen::Matrix3d(-W_ * j.q));
  Put<4>(x, J, Eigen::Matrix3d(-W_ * j.p));
  Put<5>(x, J, Eigen::Matrix3d(-W_ * j.v));
  Put<6>(x, J, Eigen::Matrix3d(W_ * (i.theta - j.theta)));
  Put<7>(x, J, Eigen::Matrix3d(W_ * (i.a_b - j.a_b)));
  Put<8>(x, J, Eigen::Vector3d(-W_ * (i.rate - j.rate)));
  return true;
}

std::optional<PointSensitivity> PointToPoint::SensitivityAt(End end, double const* const* x) const {
  const bool first = end == End::kI;
  const LidarPoint& point = first ? i_ : j_;
  const LidarPoint::Arguments at = first ? Arguments(x, u_i_b_, x) : Arguments(x + 3, u_j_b_, x);
  return ComputePointSensitivity(point, at, point.DifferentiateAt(at), Log(at.q_boresight),
                                 first ? W_ : Eigen::Matrix3d(-W_));
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> PointToPoint::Points(double const* const* x) const {
  const auto point = [](const LidarPoint& end, const LidarPoint::Arguments& at) {
    return end.At<double>(at.q_mb, at.p_mb, at.v_m, at.q_boresight, at.a_b, at.u_b, at.ddt_s);
  };
  return {point(i_, Arguments(x, u_i_b_, x)), point(j_, Arguments(x + 3, u_j_b_, x))};
}

}  // namespace dn
