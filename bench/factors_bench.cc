/// Cost of one factor evaluation, of the inertial increments and of reading text tables.
#include <benchmark/benchmark.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/geo/text_table.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/preintegration.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kRateHz = 200.0;
constexpr double kNodeSpacing_s = 0.2;
const PreintegrationNoise kNoise{6e-7, 1e-4, 1e-6};

/// Returns the inertial data of a banked, gentle turn. They are not consistent with a trajectory,
/// but no cost depends on that.
ImuData MakeImu(std::size_t samples) {
  ImuData imu;
  imu.nominal_dt_s = 1.0 / kRateHz;
  for (std::size_t k = 0; k < samples; ++k) {
    const double t_s = static_cast<double>(k + 1) / kRateHz;
    imu.samples.push_back({t_s, imu.nominal_dt_s,
                           Vector3d(0.02 * std::sin(0.9 * t_s), 0.01 * std::cos(0.7 * t_s), 0.05),
                           Vector3d(0.3 * std::cos(0.4 * t_s), 0.5 * std::sin(0.3 * t_s), -9.8)});
  }
  return imu;
}

LocalFrame Frame() { return LocalFrame({46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 0.0}); }

/// Automatic differentiation of a factor's own residual, for comparison.
template <class F>
struct AutoReference;

template <>
struct AutoReference<GnssPosition>
    : AutoFactor<AutoReference<GnssPosition>, 3, Rotation, Vec<3>, Vec<3>> {
  explicit AutoReference(const GnssPosition& f) : factor(f) {}
  template <class T>
  bool Residual(const T* q, const T* p, const T* a, T* r) const {
    return factor.Residual(q, p, a, r);
  }
  GnssPosition factor;
};

template <>
struct AutoReference<PointToPoint>
    : AutoFactor<AutoReference<PointToPoint>, 3, Rotation, Vec<3>, Vec<3>, Rotation, Vec<3>, Vec<3>,
                 LeftRotation, Vec<3>, Vec<1>> {
  explicit AutoReference(const PointToPoint& f) : factor(f) {}
  template <class T>
  bool Residual(const T* q_i, const T* p_i, const T* v_i, const T* q_j, const T* p_j, const T* v_j,
                const T* q_boresight, const T* a, const T* dt, T* r) const {
    return factor.Residual(q_i, p_i, v_i, q_j, p_j, v_j, q_boresight, a, dt, r);
  }
  PointToPoint factor;
};

/// Has two gyro and two accelerometer bias processes, like the presets.
template <>
struct AutoReference<PreintegratedInertial>
    : AutoFactor<AutoReference<PreintegratedInertial>, 9, Rotation, Vec<3>, Vec<3>, Rotation,
                 Vec<3>, Vec<3>, Vec<3>, Vec<3>, Vec<3>, Vec<3>> {
  explicit AutoReference(const PreintegratedInertial& f) : factor(f) {}
  template <class T>
  bool Residual(const T* q_i, const T* p_i, const T* v_i, const T* q_j, const T* p_j, const T* v_j,
                const T* g_0, const T* g_1, const T* a_0, const T* a_1, T* r) const {
    const std::array<const T*, 10> x{q_i, p_i, v_i, q_j, p_j, v_j, g_0, g_1, a_0, a_1};
    return factor.Residual(x.data(), r);
  }
  PreintegratedInertial factor;
};

template <class F>
F Make();

template <>
GnssPosition Make<GnssPosition>() {
  return {Vector3d(10.0, -20.0, 700.0), Noise<3>::Sigma(Vector3d(0.015, 0.015, 0.03))};
}

template <>
PreintegratedInertial Make<PreintegratedInertial>() {
  const Preintegrated increments =
      Preintegrate(MakeImu(400), 1.0, 1.0 + kNodeSpacing_s, {}, kNoise);
  return {increments, Frame(), Vector3d(0, 0, 700), Vector3d(9, 0, 700), 2, 2};
}

template <>
PointToPoint Make<PointToPoint>() {
  const ImuData imu = MakeImu(400);
  LidarEnd i, j;
  i.partial = Preintegrate(imu, 0.4, 0.53, {}, kNoise);
  j.partial = Preintegrate(imu, 1.2, 1.31, {}, kNoise);
  i.u_s = Vector3d(170.0, 0.0, 40.0);
  j.u_s = Vector3d(165.0, 0.0, -55.0);
  i.p_nominal_m = Vector3d(0.0, 0.0, 700.0);
  j.p_nominal_m = Vector3d(40.0, 100.0, 700.0);
  Eigen::Matrix3d R_bs;
  R_bs << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return {Frame(), {i, j, R_bs, 0.0, Noise<3>::Sigma(0.06)}};
}

/// Values of a factor's blocks, and storage for its residual and Jacobians.
class Workspace {
 public:
  explicit Workspace(const FactorBase& factor)
      : residual_(static_cast<std::size_t>(factor.residual_size())) {
    double next = 0.1;
    for (const BlockKind& kind : factor.block_kinds()) {
      std::vector<double> value;
      for (int k = 0; k < kind.stored_size; ++k) value.push_back(next += 0.01);
      if (kind.parametrisation != Parametrisation::kVector) {
        Eigen::Map<Eigen::Vector4d>(value.data()).normalize();
      }
      values_.push_back(std::move(value));
      jacobians_.emplace_back(static_cast<std::size_t>(factor.residual_size() * kind.stored_size));
    }
    for (const auto& value : values_) x_.push_back(value.data());
    for (auto& jacobian : jacobians_) J_.push_back(jacobian.data());
  }

  bool Evaluate(const FactorBase& factor) {
    return factor.Evaluate(x_.data(), residual_.data(), J_.data());
  }

  const std::vector<const double*>& x() const { return x_; }

 private:
  std::vector<std::vector<double>> values_;
  std::vector<double> residual_;
  std::vector<std::vector<double>> jacobians_;
  std::vector<const double*> x_;
  std::vector<double*> J_;
};

/// Returns the largest difference of the tangent Jacobians, relative to the largest entry.
double JacobianDifference(const FactorBase& a, const FactorBase& b,
                          const std::vector<const double*>& x) {
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J_a, J_b;
  if (!EvaluateInTangent(a, x, &r, &J_a) || !EvaluateInTangent(b, x, &r, &J_b)) return 1.0;
  double difference = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < J_a.size(); ++k) {
    difference = std::max(difference, (J_a[k] - J_b[k]).cwiseAbs().maxCoeff());
    largest = std::max(largest, J_a[k].cwiseAbs().maxCoeff());
  }
  return difference / largest;
}

void EvaluateLoop(benchmark::State& state, const FactorBase& factor) {
  Workspace workspace(factor);
  for (auto _ : state) {
    bool defined = workspace.Evaluate(factor);
    benchmark::DoNotOptimize(defined);
    benchmark::ClobberMemory();
  }
}

template <class F>
void BM_Analytic(benchmark::State& state) {
  EvaluateLoop(state, Make<F>());
}

template <class F>
void BM_Autodiff(benchmark::State& state) {
  constexpr double kSame = 1e-9;
  const F factor = Make<F>();
  const AutoReference<F> twin(factor);
  if (JacobianDifference(factor, twin, Workspace(factor).x()) > kSame) {
    state.SkipWithError("the Jacobians differ from the analytic ones");
    return;
  }
  EvaluateLoop(state, twin);
}

BENCHMARK(BM_Analytic<PreintegratedInertial>);
BENCHMARK(BM_Autodiff<PreintegratedInertial>);
BENCHMARK(BM_Analytic<PointToPoint>);
BENCHMARK(BM_Autodiff<PointToPoint>);
BENCHMARK(BM_Analytic<GnssPosition>);
BENCHMARK(BM_Autodiff<GnssPosition>);

/// Preintegrates 20 minutes at 200 Hz between `rate` nodes per second.
void BM_Preintegrate(benchmark::State& state) {
  constexpr std::size_t kSamples = 240000;
  const ImuData imu = MakeImu(kSamples);
  const auto rate = static_cast<double>(state.range(0));
  const auto intervals = static_cast<int>(static_cast<double>(kSamples) / kRateHz * rate);
  for (auto _ : state) {
    for (int k = 0; k < intervals; ++k) {
      const Preintegrated p = Preintegrate(imu, k / rate, (k + 1) / rate, {}, kNoise);
      benchmark::DoNotOptimize(p.delta_p.sum());
    }
  }
  state.counters["per_sample"] = benchmark::Counter(
      static_cast<double>(kSamples),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_Preintegrate)
    ->ArgName("node_rate_hz")
    ->Arg(1)
    ->Arg(5)
    ->Arg(20)
    ->Unit(benchmark::kMillisecond);

/// A temporary IMU.txt that is deleted with the object.
class TemporaryImuFile {
 public:
  explicit TemporaryImuFile(std::size_t rows)
      : path_(std::filesystem::temp_directory_path() /
              ("dn_bench_imu_" + std::to_string(getpid()) + ".txt")) {
    std::ofstream out(path_);
    for (const ImuSample& s : MakeImu(rows).samples) {
      out << FormatDouble(381000.0 + s.t_s);
      for (int i = 0; i < 3; ++i) out << ',' << FormatDouble(s.w_ib_b_radps[i]);
      for (int i = 0; i < 3; ++i) out << ',' << FormatDouble(s.f_b_mps2[i]);
      out << '\n';
    }
  }
  ~TemporaryImuFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryImuFile(const TemporaryImuFile&) = delete;
  TemporaryImuFile& operator=(const TemporaryImuFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

constexpr std::size_t kRows = 100000;

void BM_ReadTextTable(benchmark::State& state) {
  const TemporaryImuFile file(kRows);
  for (auto _ : state) benchmark::DoNotOptimize(ReadTextTable(file.path(), {7}).rows());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kRows));
}
BENCHMARK(BM_ReadTextTable)->Unit(benchmark::kMillisecond);

void BM_ReadImu(benchmark::State& state) {
  const TemporaryImuFile file(kRows);
  for (auto _ : state) benchmark::DoNotOptimize(ReadImu(file.path(), {}).samples.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kRows));
}
BENCHMARK(BM_ReadImu)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dn
