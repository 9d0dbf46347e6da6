// Two flights with one boresight, adjusted together.
//
// Each flight is adjusted alone; then both networks are appended to one, which shares the block of
// the boresight. Prints the angles and sigmas of all three. Fails unless the common estimate is
// within four sigmas of the truth, and the information matrices of the flights add up.
#include <dn/diagnosis/solution.h>
#include <dn/sim/simulate.h>
#include <dn/solvers/solve.h>

#include <cstdio>

void Print(const char* name, const dn::Network& net, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d angles = dn::Log(net.Value(net.Find<dn::LeftRotation>("boresight")));
  std::printf("%-8s", name);
  for (int i = 0; i < 3; ++i) {
    std::printf("  %.4f +- %.4f", dn::kDegPerRad * angles[i],
                dn::kDegPerRad * std::sqrt(covariance(i, i)));
  }
  std::printf(" deg\n");
}

int main() {
  dn::Scenario scenario = dn::ReadScenario("lar3", {"plan.warm_up_s=60", "imu.rate_hz=100"});
  scenario.pairs.count = 300;
  dn::Network both;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d truth_rad;
  for (const char* day : {"monday", "tuesday"}) {
    const dn::SimulatedFlight sim = dn::Simulate(scenario, {.seed = both.num_blocks() ? 2U : 1U});
    const dn::Solution solution(sim.flight);
    const dn::Network& net = solution.network().net();
    const Eigen::Matrix3d C = solution.marginals().Covariance(net.Find("boresight"));
    Print(day, net, C);
    information += C.inverse();
    truth_rad = sim.boresight_rad;
    both.Append(net, std::string(day) + "/", {"boresight"});
  }

  const bool converged = dn::Solve(both).converged;
  const auto boresight = both.Find<dn::LeftRotation>("boresight");
  const Eigen::Matrix3d C = dn::MarginalCovariance(both, boresight);
  Print("together", both, C);
  const Eigen::Vector3d error = dn::Log(both.Value(boresight) * dn::Exp(truth_rad).conjugate());
  const double nees = error.dot(C.inverse() * error);
  const double difference = (C.inverse() - information).norm() / information.norm();
  std::printf("squared error in sigmas %.1f of 3, difference of the information %.4f\n", nees,
              difference);
  return converged && nees < 22.0 && difference < 0.01 ? 0 : 1;
}
