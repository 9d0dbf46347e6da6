// A user's own factor for the pairs of a flight: laser ranges with a scale to estimate.
//
// LidarPoint provides the point of a lidar end as a template; this factor only defines how a range
// is read. The flight is simulated with ranges that are 1000 ppm too long. Prints the scale, and
// the boresight with and without the unknown, compared with the truth.
#include <dn/diagnosis/solution.h>
#include <dn/factors/point_to_point.h>
#include <dn/sim/simulate.h>

#include <cmath>
#include <cstdio>

class ScaledPair : public dn::AutoFactor<ScaledPair, 3, dn::Rotation, dn::Vec<3>, dn::Vec<3>,
                                         dn::Rotation, dn::Vec<3>, dn::Vec<3>, dn::LeftRotation,
                                         dn::Vec<3>, dn::Vec<1>, dn::Scalar>,
                   public dn::PointPairFactor {
 public:
  ScaledPair(const dn::LocalFrame& frame, const dn::PreparedPair& pair)
      : i_(frame, pair.i.partial, pair.i.p_nominal_m),
        j_(frame, pair.j.partial, pair.j.p_nominal_m),
        u_i_b_(pair.R_bs_nominal * pair.i.u_s),
        u_j_b_(pair.R_bs_nominal * pair.j.u_s),
        dt_s_(pair.dt_nominal_s),
        W_(pair.noise_m.sqrt_information()) {}

  template <class T>
  bool Residual(const T* q_i, const T* p_i, const T* v_i, const T* q_j, const T* p_j, const T* v_j,
                const T* boresight, const T* a, const T* dt, const T* scale, T* r) const {
    const auto x_i = Point(i_, u_i_b_, q_i, p_i, v_i, boresight, a, dt, scale);
    const auto x_j = Point(j_, u_j_b_, q_j, p_j, v_j, boresight, a, dt, scale);
    Eigen::Map<Eigen::Matrix<T, 3, 1>>(r).noalias() = W_.cast<T>() * (x_i - x_j);
    return true;
  }

  std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const override {
    return {Point(i_, u_i_b_, x[0], x[1], x[2], x[6], x[7], x[8], x[9]),
            Point(j_, u_j_b_, x[3], x[4], x[5], x[6], x[7], x[8], x[9])};
  }

 private:
  template <class T>
  Eigen::Matrix<T, 3, 1> Point(const dn::LidarPoint& end, const Eigen::Vector3d& u_b, const T* q,
                               const T* p, const T* v, const T* boresight, const T* a, const T* dt,
                               const T* scale) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Vec3 true_u_b = u_b.cast<T>() / (1.0 + scale[0]);
    return end.At<T>(Quaternion(q), Vec3(p), Vec3(v), Quaternion(boresight), Vec3(a), true_u_b,
                     dt[0] - dt_s_);
  }

  dn::LidarPoint i_, j_;
  Eigen::Vector3d u_i_b_, u_j_b_;
  double dt_s_;
  Eigen::Matrix3d W_;
};

void Print(const char* name, const dn::Solution& solution, const Eigen::Vector3d& truth_rad) {
  const dn::BoresightResult boresight = solution.CheckedBoresight();
  const Eigen::Vector3d in_sigmas =
      (boresight.angles_rad - truth_rad).cwiseQuotient(boresight.sigma_rad());
  std::printf("%s: boresight %.1f %.1f %.1f sigma from the truth\n", name, in_sigmas.x(),
              in_sigmas.y(), in_sigmas.z());
}

int main() {
  constexpr double kScale = 1000e-6;
  dn::Scenario scenario = dn::ReadScenario("lar3");
  scenario.plan.warm_up_s = 120.0;
  scenario.imu.rate_hz = 100.0;
  scenario.pairs.count = 800;
  scenario.effects.push_back({"lidar_range_scale", {1e6 * kScale}, {}, {}});
  const dn::SimulatedFlight sim = dn::Simulate(scenario, {});
  Print("plain pairs ", dn::Solution(sim.flight), sim.boresight_rad);

  dn::Block<dn::Scalar> scale;
  dn::AdjustOptions options;
  options.network.pair_model = [&](dn::FlightNetwork& network) {
    scale = network.net().AddScalar("range scale", 0.0);
    return dn::PairModel{{scale.id}, [](const dn::Flight& flight, const dn::PreparedPair& pair) {
                           return std::make_shared<ScaledPair>(flight.frame, pair);
                         }};
  };
  const dn::Solution own(sim.flight, options);
  Print("scaled pairs", own, sim.boresight_rad);
  const double value = own.network().net().Value(scale);
  const double sigma = own.marginals().Sigma(scale);
  std::printf("scale %.0f ppm, sigma %.0f ppm, %s three sigmas of the truth\n", 1e6 * value,
              1e6 * sigma, std::abs(value - kScale) < 3.0 * sigma ? "within" : "beyond");
  return 0;
}
