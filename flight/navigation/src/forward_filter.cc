#include <dn/builder/flight_network.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/gravitation_jacobians.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/imu/strapdown.h>
#include <dn/interrupted.h>
#include <dn/navigation/directed_filter.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr int kNav = 9;  // attitude, position, velocity

// Largest changes assumed during a gap in the inertial data: angular rate of the attitude and
// acceleration.
constexpr double kGapAttitudeRadps = 0.3;
constexpr double kGapAccelMps2 = 5.0;

Eigen::Vector3d SumVectors(const std::vector<Eigen::Vector3d>& biases) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& bias : biases) sum += bias;
  return sum;
}

/// An inertial edge linearised at two poses: the whitened residual and its derivatives.
struct LinearEdge {
  Eigen::VectorXd r;
  Eigen::Matrix<double, kNav, kNav> J_begin;  ///< attitude (right), position, velocity
  Eigen::Matrix<double, kNav, kNav> J_end;
  Eigen::MatrixXd J_biases;  ///< gyro processes, then accelerometer processes
};

Eigen::Matrix3d Isotropic(double sigma) { return sigma * sigma * Eigen::Matrix3d::Identity(); }

FilterState WithoutCovariance(const FilterState& state) {
  return {state.pose, state.gyro_bias, state.accel_bias, state.gnss_error, {}};
}

class Filter {
 public:
  Filter(const Flight& flight, const FilterState& start, const FilterOptions& options)
      : flight_(flight),
        options_(options),
        calibration_(options.calibration.value_or(AssumedCalibration(flight))),
        gnss_processes_(GnssProcessesInSigmas(*flight.config.gnss)),
        state_(start) {
    const ImuModel& model = flight.config.imu->model;
    noise_ = {model.gyro.white, model.accel.white, FlightNetworkOptions{}.position_floor_m,
              model.vibration};
  }

  void PredictTo(double t_s) {
    if (t_s - state_.pose.t_s < 1e-7) return;
    if (HasGap(*flight_.imu, state_.pose.t_s, t_s)) {
      PredictOverGap(t_s);
    } else {
      PredictInertially(t_s);
    }
    StepProcesses(t_s - state_.pose.t_s);
    state_.pose.t_s = t_s;
  }

  void PredictBackTo(double t_s) {
    const double dt_s = state_.pose.t_s - t_s;
    if (dt_s < 1e-7) return;
    StepProcesses(dt_s);
    if (HasGap(*flight_.imu, t_s, state_.pose.t_s)) {
      PredictOverGap(t_s);
    } else {
      PredictBackInertially(t_s);
    }
    state_.pose.t_s = t_s;
  }

  /// Updates the state with the GNSS epoch at this time, if there is one.
  void UseEpochAt(double t_s) {
    const std::vector<MapGnssEpoch>& epochs = flight_.gnss->epochs;
    const auto at = std::lower_bound(
        epochs.begin(), epochs.end(), t_s - 1e-6,
        [](const MapGnssEpoch& epoch, double time_s) { return epoch.t_s < time_s; });
    if (at == epochs.end() || at->t_s > t_s + 1e-6) return;
    const auto index = static_cast<std::size_t>(at - epochs.begin());
    const auto& skipped = options_.skipped_epochs;
    if (std::binary_search(skipped.begin(), skipped.end(), index)) return;
    UpdatePosition(*at);
    if (UsesVelocity(*at, *flight_.config.gnss)) UpdateVelocity(*at);
  }

  void KeepState() {
    run.states.push_back(WithoutCovariance(state_));
    const Eigen::Matrix3d R = state_.pose.q_mb.toRotationMatrix();
    run.sigma_heading_rad.push_back(
        std::sqrt(R.row(2).dot(state_.covariance.topLeftCorner<3, 3>() * R.row(2).transpose())));
  }

  void UpdatePosition(const MapGnssEpoch& epoch) {
    const auto factor = MakeGnssPositionFactor(flight_, epoch, calibration_,
                                               MakeEdgeInput(Isotropic(options_.position_floor_m)));
    UpdateGnss(*factor, {state_.pose.p_mb.data(), 3}, state_.gnss_error, false);
  }

  void UpdateVelocity(const MapGnssEpoch& epoch) {
    const auto factor = MakeGnssVelocityFactor(
        flight_, epoch, calibration_, MakeEdgeInput(Isotropic(options_.velocity_floor_mps)));
    UpdateGnss(*factor, {state_.pose.v_m.data(), 6}, {}, true);
  }

  const FilterState& state() const { return state_; }
  DirectedRun run;

 private:
  GnssEdgeInput MakeEdgeInput(const Eigen::Matrix3d& added_covariance) const {
    return {state_.pose, {state_.TotalGyroBias(), state_.TotalAccelBias()}, added_covariance};
  }

  /// A part of the state and its row in the covariance.
  struct StatePart {
    const double* value;
    Eigen::Index row;
  };

  /// `measured`: the part of the state that a factor without effects depends on. `errors`: the
  /// time-correlated errors.
  void UpdateGnss(const FactorBase& factor, const StatePart& measured,
                  const std::vector<Eigen::Vector3d>& errors, bool velocity) {
    const std::vector<std::size_t> effects = GnssEffectIndices(calibration_);
    const MapPose& pose = state_.pose;
    std::vector<const double*> x{pose.q_mb.coeffs().data(), measured.value,
                                 calibration_.gnss_lever_arm_b_m.data()};
    std::vector<Eigen::Index> rows{0, measured.row, -1};
    if (!effects.empty() || !errors.empty()) {
      x[1] = pose.p_mb.data();
      rows[1] = 3;
      x.push_back(pose.v_m.data());
      rows.push_back(6);
    }
    auto row = state_.covariance.rows() - 3 * static_cast<Eigen::Index>(errors.size());
    for (const Eigen::Vector3d& error : errors) {
      x.push_back(error.data());
      rows.push_back(row);
      row += 3;
    }
    for (const std::size_t k : effects) {
      x.push_back(calibration_.effects[k].value.data());
      rows.push_back(-1);
    }
    Update(factor, x, rows, velocity);
  }

  void PredictOverGap(double t_s) {
    const double dt_s = t_s - state_.pose.t_s;  // negative for the reverse filter
    state_.pose.p_mb += dt_s * state_.pose.v_m;
    auto diagonal = state_.covariance.diagonal();
    diagonal.segment<3>(0).array() += std::pow(kGapAttitudeRadps * dt_s, 2);
    diagonal.segment<3>(3).array() += std::pow(0.5 * kGapAccelMps2 * dt_s * dt_s, 2);
    diagonal.segment<3>(6).array() += std::pow(kGapAccelMps2 * dt_s, 2);
  }

  LinearEdge Linearise(const Preintegrated& increment, const MapPose& begin, const MapPose& end) {
    const std::size_t ng = state_.gyro_bias.size();
    const std::size_t na = state_.accel_bias.size();
    const PreintegratedInertial factor(increment, flight_.frame, begin.p_mb, end.p_mb,
                                       static_cast<int>(ng), static_cast<int>(na),
                                       GravitationJacobians(calibration_, begin.p_mb));
    std::vector<const double*> x{begin.q_mb.coeffs().data(), begin.p_mb.data(), begin.v_m.data(),
                                 end.q_mb.coeffs().data(),   end.p_mb.data(),   end.v_m.data()};
    for (const Eigen::Vector3d& bias : state_.gyro_bias) x.push_back(bias.data());
    for (const Eigen::Vector3d& bias : state_.accel_bias) x.push_back(bias.data());
    for (const std::size_t k : InertialEffectIndices(calibration_)) {
      x.push_back(calibration_.effects[k].value.data());
    }
    std::vector<Eigen::MatrixXd> J;
    LinearEdge edge;
    EvaluateInTangent(factor, x, &edge.r, &J);
    edge.J_begin << J[0], J[1], J[2];
    edge.J_end << J[3], J[4], J[5];
    edge.J_biases.resize(kNav, 3 * static_cast<Eigen::Index>(ng + na));
    for (std::size_t b = 0; b < ng + na; ++b) {
      edge.J_biases.middleCols<3>(3 * static_cast<Eigen::Index>(b)) = J[6 + b];
    }
    return edge;
  }

  Preintegrated IncrementBetween(double t0_s, double t1_s) const {
    return Preintegrate(*flight_.imu, t0_s, t1_s,
                        calibration_.ImuAt(state_.TotalGyroBias(), state_.TotalAccelBias()),
                        noise_);
  }

  // The linearised edge e(x_known, x, b) = 0 gives d x = -J^-1 (J_known d x_known + J_b d b + white
  // noise).
  void CarryCovariance(const Eigen::Matrix<double, kNav, kNav>& J_known,
                       const Eigen::Matrix<double, kNav, kNav>& J,
                       const Eigen::MatrixXd& J_biases) {
    const Eigen::Index n = state_.covariance.rows();
    const Eigen::Matrix<double, kNav, kNav> inverse = J.inverse();
    Eigen::MatrixXd transition = Eigen::MatrixXd::Identity(n, n);
    transition.topLeftCorner<kNav, kNav>() = -inverse * J_known;
    transition.block(0, kNav, kNav, J_biases.cols()) = -inverse * J_biases;
    state_.covariance = transition * state_.covariance * transition.transpose();
    state_.covariance.topLeftCorner<kNav, kNav>() += inverse * inverse.transpose();
  }

  void PredictInertially(double t_s) {
    const Preintegrated increment = IncrementBetween(state_.pose.t_s, t_s);
    const MapPose next = Propagate(flight_.frame, state_.pose, increment,
                                   calibration_.GravitationAt(state_.pose.p_mb));
    const LinearEdge edge = Linearise(increment, state_.pose, next);
    CarryCovariance(edge.J_begin, edge.J_end, edge.J_biases);
    state_.pose = {state_.pose.t_s, next.q_mb, next.p_mb, next.v_m};
  }

  void PredictBackInertially(double t_s) {
    // Newton steps; the problem is nearly linear, so that the last step is at rounding level.
    constexpr int kSteps = 4;
    const Preintegrated increment = IncrementBetween(t_s, state_.pose.t_s);
    const MapPose& end = state_.pose;
    MapPose begin{t_s, (end.q_mb * increment.delta_q.conjugate()).normalized(),
                  end.p_mb - increment.dt_s() * end.v_m, end.v_m};
    for (int i = 0; i < kSteps; ++i) {
      const LinearEdge edge = Linearise(increment, begin, end);
      const Eigen::Matrix<double, kNav, 1> step = -edge.J_begin.inverse() * edge.r;
      begin.q_mb = (begin.q_mb * Exp(Eigen::Vector3d(step.segment<3>(0)))).normalized();
      begin.p_mb += step.segment<3>(3);
      begin.v_m += step.segment<3>(6);
    }
    const LinearEdge edge = Linearise(increment, begin, end);
    CarryCovariance(edge.J_end, edge.J_begin, edge.J_biases);
    state_.pose = {end.t_s, begin.q_mb, begin.p_mb, begin.v_m};
  }

  void StepProcesses(double dt_s) {
    const ImuModel& model = flight_.config.imu->model;
    Eigen::Index row = kNav;
    const auto step = [&](const std::vector<BiasProcess>& processes,
                          std::vector<Eigen::Vector3d>& values) {
      for (std::size_t i = 0; i < values.size(); ++i, row += 3) {
        StepProcess(processes[i], dt_s, row, &values[i]);
      }
    };
    step(model.gyro.processes, state_.gyro_bias);
    step(model.accel.processes, state_.accel_bias);
    step(gnss_processes_, state_.gnss_error);
  }

  void StepProcess(const BiasProcess& process, double dt_s, Eigen::Index row,
                   Eigen::Vector3d* value) {
    auto variance = state_.covariance.diagonal().segment<3>(row).array();
    if (process.type == BiasProcess::Type::kGaussMarkov) {
      const GaussMarkovStep gm = DiscretiseGaussMarkov(process.sigma, process.tau_s, dt_s);
      *value *= gm.phi;
      state_.covariance.middleRows<3>(row) *= gm.phi;
      state_.covariance.middleCols<3>(row) *= gm.phi;
      variance += gm.q;
    } else if (process.type == BiasProcess::Type::kRandomWalk) {
      variance += process.sigma * process.sigma * dt_s;
    }
  }

  // rows: row of each block of the factor in the state; -1: the block is known.
  void Update(const FactorBase& factor, const std::vector<const double*>& x,
              const std::vector<Eigen::Index>& rows, bool velocity) {
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    EvaluateInTangent(factor, x, &r, &J);
    const Eigen::Index n = state_.covariance.rows();
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3, n);
    for (std::size_t b = 0; b < rows.size(); ++b) {
      if (rows[b] >= 0) H.middleCols<3>(rows[b]) = J[b];
    }
    const Eigen::MatrixXd PHt = state_.covariance * H.transpose();
    const Eigen::Matrix3d predicted = H * PHt;
    Eigen::Matrix3d S = predicted + Eigen::Matrix3d::Identity();
    const Eigen::Vector3d innovation = -r;
    const double nis = innovation.dot(S.llt().solve(innovation));
    run.innovations.push_back(
        {state_.pose.t_s, velocity, innovation.cwiseQuotient(S.diagonal().cwiseSqrt()), nis});
    double noise_scale = 1.0;
    if (options_.huber_sigmas > 0.0 && nis > options_.huber_sigmas * options_.huber_sigmas) {
      noise_scale = std::sqrt(nis) / options_.huber_sigmas;
      S = predicted + noise_scale * noise_scale * Eigen::Matrix3d::Identity();
    }
    const Eigen::LLT<Eigen::Matrix3d> llt(S);
    const Eigen::MatrixXd K = llt.solve(PHt.transpose()).transpose();
    const double weighted = innovation.dot(llt.solve(innovation));
    const Eigen::Matrix3d L = llt.matrixL();
    run.log_likelihood -= 0.5 * weighted + L.diagonal().array().log().sum();
    Correct(K * innovation);
    const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(n, n) - K * H;
    state_.covariance =
        I_KH * state_.covariance * I_KH.transpose() + noise_scale * noise_scale * K * K.transpose();
  }

  void Correct(const Eigen::VectorXd& step) {
    state_.pose.q_mb = (state_.pose.q_mb * Exp(Eigen::Vector3d(step.segment<3>(0)))).normalized();
    state_.pose.p_mb += step.segment<3>(3);
    state_.pose.v_m += step.segment<3>(6);
    Eigen::Index row = kNav;
    for (auto* values : {&state_.gyro_bias, &state_.accel_bias, &state_.gnss_error}) {
      for (Eigen::Vector3d& value : *values) {
        value += step.segment<3>(row);
        row += 3;
      }
    }
  }

  const Flight& flight_;
  FilterOptions options_;
  CalibrationState calibration_;
  std::vector<BiasProcess> gnss_processes_;
  FilterState state_;
  PreintegrationNoise noise_;
};

}  // namespace

Eigen::Vector3d FilterState::TotalGyroBias() const { return SumVectors(gyro_bias); }
Eigen::Vector3d FilterState::TotalAccelBias() const { return SumVectors(accel_bias); }

FilterState MakeFilterState(const Flight& flight, const MapPose& pose,
                            const Eigen::Vector3d& gyro_bias_radps,
                            const Eigen::Vector3d& accel_bias_mps2,
                            const Eigen::Vector3d& sigma_attitude_rad, double sigma_position_m,
                            double sigma_velocity_mps) {
  const ImuModel& model = flight.config.imu->model;
  FilterState state;
  state.pose = pose;
  std::vector<double> variances;
  const auto add = [&](const std::vector<BiasProcess>& processes, Eigen::Vector3d start,
                       std::vector<Eigen::Vector3d>* values) {
    for (const BiasProcess& process : processes) {
      values->push_back(start);
      start.setZero();
      const bool walk = process.type == BiasProcess::Type::kRandomWalk;
      variances.push_back(walk ? 1e-30 : process.sigma * process.sigma);
    }
  };
  add(model.gyro.processes, gyro_bias_radps, &state.gyro_bias);
  add(model.accel.processes, accel_bias_mps2, &state.accel_bias);
  add(GnssProcessesInSigmas(*flight.config.gnss), Eigen::Vector3d::Zero(), &state.gnss_error);
  const Eigen::Index n = kNav + 3 * static_cast<Eigen::Index>(variances.size());
  state.covariance = Eigen::MatrixXd::Zero(n, n);
  auto diagonal = state.covariance.diagonal();
  diagonal.segment<3>(0) = sigma_attitude_rad.cwiseAbs2();
  diagonal.segment<3>(3).setConstant(sigma_position_m * sigma_position_m);
  diagonal.segment<3>(6).setConstant(sigma_velocity_mps * sigma_velocity_mps);
  for (std::size_t i = 0; i < variances.size(); ++i) {
    diagonal.segment<3>(kNav + 3 * static_cast<Eigen::Index>(i)).setConstant(variances[i]);
  }
  return state;
}

FilterRun RunForwardFilter(const Flight& flight, const std::vector<double>& times,
                           const FilterState& start, const FilterOptions& options) {
  return RunFilter(flight, times, start, FilterDirection::kForward, options);
}

DirectedRun RunFilter(const Flight& flight, const std::vector<double>& times,
                      const FilterState& start, FilterDirection direction,
                      const FilterOptions& options) {
  const bool reverse = direction == FilterDirection::kReverse;
  const double last_s = reverse ? start.pose.t_s + 1e-7 : options.t_end_s;
  const auto past = std::upper_bound(times.begin(), times.end(), last_s);
  std::vector<double> in_order(times.begin(), past);
  if (reverse) std::reverse(in_order.begin(), in_order.end());
  Filter filter(flight, start, options);
  for (const double t_s : in_order) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    reverse ? filter.PredictBackTo(t_s) : filter.PredictTo(t_s);
    filter.UseEpochAt(t_s);
    filter.KeepState();
  }
  filter.run.last = filter.state();
  return std::move(filter.run);
}

}  // namespace dn
