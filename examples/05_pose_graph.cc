// A pose graph in the g2o format: reads and solves it, and computes the covariance of every pose.
//
// Usage: example_05_pose_graph [file.g2o]; the default is two laps on a ring with ten loop
// closures. Prints the figures of the adjustment and the standard deviations of the poses with the
// best and worst position.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <string>

using Matrix6 = Eigen::Matrix<double, 6, 6>;

dn::Transform<double> ReadTransform(std::istream& in) {
  dn::Transform<double> T;
  for (double& x : T.p) in >> x;
  for (double& x : T.q.coeffs()) in >> x;
  T.q.normalize();
  return T;
}

/// Converts the information of (translation, vector part of the quaternion) to that of (rotation,
/// translation).
Matrix6 ReadInformation(std::istream& in) {
  Matrix6 g2o = Matrix6::Zero(), D = Matrix6::Zero();
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) in >> g2o(r, c);
  }
  D.topRightCorner<3, 3>().setIdentity();
  D.bottomLeftCorner<3, 3>() = 0.5 * Eigen::Matrix3d::Identity();
  return D.transpose() * Matrix6(g2o.selfadjointView<Eigen::Upper>()) * D;
}

int main(int argc, char** argv) {
  std::ifstream in(argc > 1 ? argv[1] : DN_EXAMPLE_G2O);
  dn::Network net;
  std::map<int, dn::Block<dn::Pose>> poses;
  for (std::string word; in >> word;) {
    int i = 0, j = 0;
    if (word == "VERTEX_SE3:QUAT") {
      in >> i;
      poses[i] = net.AddPose(std::to_string(i), ReadTransform(in));
    } else if (word == "FIX") {
      in >> i;
      net.Hold(poses.at(i));
    } else if (word == "EDGE_SE3:QUAT") {
      in >> i >> j;
      const dn::Transform<double> T_ji = ReadTransform(in).Inverse();
      net.Add([=](const auto& T_mi,
                  const auto& T_mj) { return (T_ji * T_mi.Inverse() * T_mj).ToVector(); },
              dn::Noise<6>::Information(ReadInformation(in)), poses.at(i), poses.at(j));
    }
  }

  const dn::SolveSummary summary = dn::Solve(net);
  dn::Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  std::map<double, int> by_sigma;
  for (const auto& [i, pose] : poses) {
    by_sigma[std::sqrt(marginals.Covariance(pose).bottomRightCorner<3, 3>().trace())] = i;
  }
  std::printf("%zu poses, %d factors, %d iterations, sigma0 %.3f of %ld redundant\n", poses.size(),
              net.num_factors(), summary.iterations, summary.adjusted.sigma0(),
              summary.adjusted.redundancy());
  for (const auto& [sigma_m, i] : {*++by_sigma.begin(), *by_sigma.rbegin()}) {
    const Eigen::Vector3d s = marginals.Covariance(poses[i]).diagonal().head<3>().cwiseSqrt();
    std::printf("pose %2d  sigma of the position %.3f m, of the rotation %.4f %.4f %.4f rad\n", i,
                sigma_m, s.x(), s.y(), s.z());
  }
  return summary.converged ? 0 : 1;
}
