// A simulated flight with two sensors of one's own: a barometer with an offset, and a heading with
// a misalignment.
#include <dn/diagnosis/solution.h>
#include <dn/sim/simulate.h>

#include <random>

#include "check.h"

namespace {

constexpr double kOffset_m = 3.0, kMisalignment_rad = 0.01;
constexpr double kBarometer_m = 0.5, kHeading_rad = 2e-3;

/// Returns the heading of the body's forward axis, from north to east.
template <class Quaternion>
auto Heading(const Quaternion& q_mb) {
  using std::atan2;
  const auto forward = (q_mb * Eigen::Matrix<typename Quaternion::Scalar, 3, 1>::UnitX()).eval();
  return atan2(forward[0], forward[1]);
}

struct OwnUnknowns {
  dn::Block<dn::Scalar> offset, misalignment;
};

OwnUnknowns AddSensors(const dn::SimulatedFlight& sim, dn::FlightNetwork* flight) {
  std::mt19937 rng(2);
  std::normal_distribution<double> normal;
  dn::Network& net = flight->net();
  const OwnUnknowns own{net.AddScalar("barometer offset", 0.0),
                        net.AddScalar("heading misalignment", 0.0)};
  for (const dn::NodeBlocks& node : flight->nodes()) {
    const dn::MapPose truth = sim.truth->Pose(node.t_s);
    const double height_m = truth.p_mb.z() + kOffset_m + kBarometer_m * normal(rng);
    const double heading_rad = Heading(truth.q_mb) + kMisalignment_rad + kHeading_rad * normal(rng);
    net.Tag(net.Add([=](const auto& p, const auto& o) { return p.z() + o - height_m; },
                    dn::Noise<1>::Sigma(kBarometer_m), node.p_mb, own.offset),
            "barometer", node.t_s);
    net.Tag(net.Add(
                [=](const auto& q, const auto& m) {
                  using std::atan2, std::cos, std::sin;
                  const auto r = Heading(q) + m - heading_rad;
                  return atan2(sin(r), cos(r));
                },
                dn::Noise<1>::Sigma(kHeading_rad), node.q_mb, own.misalignment),
            "heading", node.t_s);
  }
  return own;
}

}  // namespace

int main() {
  dn::Scenario scenario = dn::ReadScenario("lar2");
  scenario.plan.warm_up_s = 60.0;
  scenario.imu.rate_hz = 100.0;
  scenario.pairs.count = 0;
  const dn::SimulatedFlight sim = dn::Simulate(scenario, {});
  OwnUnknowns own;
  dn::AdjustOptions options;
  options.with_pairs = false;
  options.customise = [&](dn::FlightNetwork& flight) { own = AddSensors(sim, &flight); };
  const dn::Solution solution(sim.flight, options);

  const dn::Network& net = solution.network().net();
  const double offset_m = solution.marginals().Sigma(own.offset);
  const double misalignment_rad = solution.marginals().Sigma(own.misalignment);
  bool good = Agrees("offset", net.Value(own.offset), kOffset_m, offset_m);
  good = Agrees("misalignment", net.Value(own.misalignment), kMisalignment_rad, misalignment_rad) &&
         good;
  good = Between("sigma of the offset, m", offset_m, 1e-3, 0.1) && good;
  return Between("sigma of the misalignment, rad", misalignment_rad, 1e-6, 1e-3) && good ? 0 : 1;
}
