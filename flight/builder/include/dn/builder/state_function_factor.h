#pragma once

#include <dn/factor.h>
#include <dn/factors/state_after_node.h>
#include <dn/function_factor.h>
#include <dn/imu/preintegration.h>
#include <dn/noise.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace dn {

/// Judges a function of the state between nodes and of further blocks.
template <class Function, class... Own>
using CheckStateFunction =
    core_internal::FunctionCheck<DynamicJet, Function, KinematicState<DynamicJet>,
                                 core_internal::BlockView<Own, DynamicJet>...>;

/// Factor on a function of the state between nodes and of additional blocks, r = W f(state,
/// own...), differentiated automatically. See FlightNetwork::AddAt.
///
///   block     | symbol | stored | tangent | meaning
///   ----------|--------|--------|---------|-------------------------------------------------
///     0       | q_mb   |   4    |    3    | rotation body -> map of the node before, (x, y, z, w)
///     1       | p_mb   |   3    |    3    | its body origin in map, m
///     2       | v_m    |   3    |    3    | its velocity with respect to the Earth in map, m/s
///     3 ..    | b_g    |   3    |    3    | one per gyro bias process, body, rad/s
///     then    | b_a    |   3    |    3    | one per accelerometer bias process, body, m/s^2
///     last    |        |        |         | the additional blocks
///
/// The increments are corrected for the biases to first order with the derivatives of
/// Preintegrated.
template <class Function, int R, class... Own>
class StateFunctionFactor final
    : public DynamicAutoFactor<StateFunctionFactor<Function, R, Own...>> {
 public:
  StateFunctionFactor(Function function, const Noise<R>& noise, const StateAfterNode& state,
                      const Preintegrated& increments, std::size_t num_gyro_biases,
                      std::size_t num_accel_biases)
      : DynamicAutoFactor<StateFunctionFactor>(R, Kinds(num_gyro_biases + num_accel_biases)),
        function_(std::move(function)),
        W_(noise.sqrt_information()),
        state_(state),
        increments_(increments),
        num_gyro_biases_(num_gyro_biases),
        num_accel_biases_(num_accel_biases) {}

  template <class T>
  bool Residual(const T* const* x, T* r) const {
    return Residual(x, r, std::index_sequence_for<Own...>{});
  }

 private:
  static std::vector<BlockKind> Kinds(std::size_t num_biases) {
    std::vector<BlockKind> kinds{MakeBlockKind<Rotation>(), MakeBlockKind<Vec<3>>(),
                                 MakeBlockKind<Vec<3>>()};
    kinds.insert(kinds.end(), num_biases, MakeBlockKind<Vec<3>>());
    (kinds.push_back(MakeBlockKind<Own>()), ...);
    return kinds;
  }

  template <class T, std::size_t... I>
  bool Residual(const T* const* x, T* r, std::index_sequence<I...>) const {
    [[maybe_unused]] const T* const* own = x + 3 + num_gyro_biases_ + num_accel_biases_;
    return core_internal::Whiten<R, T>(W_, function_(StateAt(x), MakeView<Own>(own[I])...), r);
  }

  template <class T>
  KinematicState<T> StateAt(const T* const* x) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const auto times = [](const Eigen::Matrix3d& M, const Vec3& d) {
      return Vec3(M.template cast<T>() * d);
    };
    const Preintegrated& at = increments_;
    const Vec3 d_bg = Sum(x + 3, num_gyro_biases_, at.linearisation.gyro_bias_radps);
    const Vec3 d_ba =
        Sum(x + 3 + num_gyro_biases_, num_accel_biases_, at.linearisation.accel_bias_mps2);
    return state_.At(
        Quaternion(Eigen::Map<const Quaternion>(x[0])), Vec3(Eigen::Map<const Vec3>(x[1])),
        Vec3(Eigen::Map<const Vec3>(x[2])),
        Quaternion(at.delta_q.template cast<T>() * Exp(times(at.J_q_bg, d_bg))),
        Vec3(at.delta_v.template cast<T>() + times(at.J_v_bg, d_bg) + times(at.J_v_ba, d_ba)),
        Vec3(at.delta_p.template cast<T>() + times(at.J_p_bg, d_bg) + times(at.J_p_ba, d_ba)));
  }

  /// Returns the sum of the bias blocks minus the bias at which the increments were integrated.
  template <class T>
  static Eigen::Matrix<T, 3, 1> Sum(const T* const* x, std::size_t count,
                                    const Eigen::Vector3d& linearisation) {
    Eigen::Matrix<T, 3, 1> sum = -linearisation.template cast<T>();
    for (std::size_t i = 0; i < count; ++i) sum += Eigen::Map<const Eigen::Matrix<T, 3, 1>>(x[i]);
    return sum;
  }

  Function function_;
  Eigen::Matrix<double, R, R> W_;
  StateAfterNode state_;
  Preintegrated increments_;
  std::size_t num_gyro_biases_, num_accel_biases_;
};

}  // namespace dn
