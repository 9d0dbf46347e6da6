#pragma once

#include <dn/factor.h>
#include <dn/factors/lidar_point.h>
#include <dn/factors/point_sensitivity.h>
#include <dn/factors/prepared_pair.h>
#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <optional>
#include <utility>

namespace dn {

/// A factor on a pair of points.
class PointPairFactor {
 public:
  virtual ~PointPairFactor() = default;

  /// Returns the two georeferenced points in map, m, at the given blocks (first x_i, then x_j).
  virtual std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const = 0;

  enum class End { kI, kJ };
  /// Returns the Jacobians of the residual with respect to changes of one point at the given
  /// blocks. Returns nullopt if the factor does not provide them.
  virtual std::optional<PointSensitivity> SensitivityAt(End /*end*/,
                                                        double const* const* /*x*/) const {
    return std::nullopt;
  }

 protected:
  PointPairFactor() = default;
  PointPairFactor(const PointPairFactor&) = default;
  PointPairFactor& operator=(const PointPairFactor&) = default;
};

/// One ground point observed at two epochs.
///
///   r   = W (x_i - x_j)                                                       [3], unitless
///
/// with the LidarPoint x of each end, u_b = R_bs_nominal u_s and ddt = dt - dt_nominal. The time
/// tag in the file is t + dt; the partial increments end at tag - dt_nominal.
///
///   block | symbol      | stored | tangent | meaning
///   ------|-------------|--------|---------|-----------------------------------------------------
///    0, 3 | q_mb        |   4    |    3    | rotation body -> map of the node at i, j (x, y, z, w)
///    1, 4 | p_mb        |   3    |    3    | body origin in map of the node, m
///    2, 5 | v_m         |   3    |    3    | velocity of the node with respect to the Earth, m/s
///     6   | q_boresight |   4    |    3    | Exp(theta), left of R_bs_nominal, about the body axes
///     7   | a_b         |   3    |    3    | lidar lever arm in body, m
///     8   | dt          |   1    |    1    | time offset of the lidar tags, s
///
/// Jacobians are analytic; the tangent of the boresight is left, of the attitudes right, rad. The
/// biases are not blocks of this edge: the partial increments are corrected at their linearisation
/// and are repreintegrated when the biases change. Over at most a second the neglected term is
/// below the white noise of the increments (EndNoise). Use PointToPointBetweenNodes for bridges to
/// the nodes after the epochs, or for calibration values beyond these blocks. Degenerate when: both
/// ends share the attitude (boresight and lever arm cancel). Source: Brun & Skaloud, eq. (1) and
/// the point-to-point observation, for any lidar epoch.
class PointToPoint final : public Factor<PointToPoint, 3, Rotation, Vec<3>, Vec<3>, Rotation,
                                         Vec<3>, Vec<3>, LeftRotation, Vec<3>, Vec<1>>,
                           public PointPairFactor {
 public:
  /// Throws InvalidInput if a laser vector is zero, or if it, a nominal position, the mounting
  /// matrix or the offset is not finite. Also throws if the mounting matrix is not a rotation
  /// (1e-6), or if an end has a bridge or another scanner.
  PointToPoint(const LocalFrame& frame, const PreparedPair& pair);

  template <class T>
  bool Residual(const T* q_i, const T* p_i, const T* v_i, const T* q_j, const T* p_j, const T* v_j,
                const T* q_boresight_data, const T* a_b_data, const T* dt_data, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    using Quat = Eigen::Quaternion<T>;
    const Quat q_boresight(q_boresight_data);
    const Vec3 a_b = Eigen::Map<const Vec3>(a_b_data);
    const T ddt = dt_data[0] - T(dt_nominal_s_);
    const auto point = [&](const LidarPoint& end, const Eigen::Vector3d& u_b, const T* q,
                           const T* p, const T* v) {
      return end.At<T>(Quat(q), Vec3(Eigen::Map<const Vec3>(p)), Vec3(Eigen::Map<const Vec3>(v)),
                       q_boresight, a_b, Vec3(u_b.template cast<T>()), ddt);
    };
    const Vec3 x_i = point(i_, u_i_b_, q_i, p_i, v_i);
    const Vec3 x_j = point(j_, u_j_b_, q_j, p_j, v_j);
    Eigen::Map<Vec3> r(r_data);
    r.noalias() = W_.template cast<T>() * (x_i - x_j);
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const override;
  std::optional<PointSensitivity> SensitivityAt(End end, double const* const* x) const override;

 private:
  LidarPoint::Arguments Arguments(double const* const* node, const Eigen::Vector3d& u_b,
                                  double const* const* x) const;

  LidarPoint i_, j_;
  Eigen::Vector3d u_i_b_, u_j_b_;  // R_bs_nominal u_s
  double dt_nominal_s_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
