// An odometer in a measured drive, with unknown scale and direction.
//
// The inertial data are measured. The odometer readings are simulated: the speed of the reference,
// 2 % too large, with noise of 5 cm/s. GNSS is withheld over the last 40 s. Prints the position
// errors there, without and with the odometer, and its unknowns. The drive is psins-car of
// docs/validation/real-data.md; the example needs its folder.
#include <cstdio>
#include <random>

#include "withheld_gnss.h"

constexpr double kScale = 0.02, kSigma_mps = 0.05;

/// Returns two residuals. The first is computed minus measured speed along the odometer's direction
/// (`angle` right of the nose). The second is the computed speed across it, because a wheel does
/// not slip sideways.
template <class T>
Eigen::Matrix<T, 2, 1> AlongAndAcross(const dn::KinematicState<T>& state, const T& scale,
                                      const T& angle, double reading_mps) {
  using std::cos, std::sin;
  const Eigen::Matrix<T, 3, 1> nose = state.q_mb * Eigen::Matrix<T, 3, 1>::UnitX();
  const Eigen::Matrix<T, 2, 1> h = nose.template head<2>().normalized();  // east, north
  const T ahead = h.x() * state.v_m.x() + h.y() * state.v_m.y();
  const T right = h.y() * state.v_m.x() - h.x() * state.v_m.y();
  return {(1.0 + scale) * (cos(angle) * ahead + sin(angle) * right) - reading_mps,
          cos(angle) * right - sin(angle) * ahead};
}

int main() {
  const std::optional<dn::Flight> flight = ReadMeasured("psins-car");
  if (!flight) return 0;
  const dn::TimeInterval end{60.0, 100.0};
  AdjustWithheld("inertial data alone", *flight, end, [](dn::FlightNetwork&) {});

  const std::vector<dn::MapPose> reference = flight->reference->ToMapPoses(flight->frame);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, kSigma_mps);
  dn::Block<dn::Scalar> scale, angle;
  const auto add_odometer = [&](dn::FlightNetwork& network) {
    scale = network.net().AddScalar("odometer scale", 0.0);
    angle = network.net().AddScalar("odometer direction", 0.0);
    for (double t_s = 1.0; t_s < 99.0; t_s += 0.5) {
      const Eigen::Vector3d v_m = dn::InterpolatePose(reference, t_s).v_m;
      const double reading_mps = (1.0 + kScale) * v_m.head<2>().norm() + noise(random);
      network.AddAt(
          t_s,
          [=](const auto& state, const auto& k, const auto& a) {
            return AlongAndAcross(state, k, a, reading_mps);
          },
          dn::Noise<2>::Sigma(kSigma_mps), scale, angle);
    }
  };
  const dn::Solution solution = AdjustWithheld("with the odometer  ", *flight, end, add_odometer);
  const dn::Network& net = solution.network().net();
  const dn::Marginals& marginals = solution.marginals();
  std::printf("scale %.4f, sigma %.4f (put in %.4f); direction %.2f deg, sigma %.2f deg\n",
              net.Value(scale), marginals.Sigma(scale), kScale, dn::kDegPerRad * net.Value(angle),
              dn::kDegPerRad * marginals.Sigma(angle));
  return 0;
}
