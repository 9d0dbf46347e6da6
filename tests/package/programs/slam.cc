// Plane SLAM: odometry around a square, and ranges and bearings to landmarks at unknown positions.
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <random>
#include <vector>

#include "check.h"

namespace {

using PoseBlock = dn::Block<dn::Vec<3>>;  // x, y in m, heading in rad
using Landmark = dn::Block<dn::Vec<2>>;

template <class T>
T Wrapped(const T& angle) {
  using std::atan2, std::cos, std::sin;
  return atan2(sin(angle), cos(angle));
}

template <class T, class U>
Eigen::Matrix<T, 2, 1> InBody(const Eigen::Matrix<T, 3, 1>& pose, const U& point) {
  using std::cos, std::sin;
  const T dx = point[0] - pose[0], dy = point[1] - pose[1];
  return {T(cos(pose[2]) * dx + sin(pose[2]) * dy), T(cos(pose[2]) * dy - sin(pose[2]) * dx)};
}

const dn::Noise<3> kOdometry = dn::Noise<3>::Sigma({0.05, 0.05, 0.01});
const dn::Noise<2> kRangeBearing = dn::Noise<2>::Sigma({0.1, 0.01});

void AddOdometry(dn::Network* net, PoseBlock from, PoseBlock to, const Eigen::Vector3d& z) {
  net->Add(
      [=](const auto& a, const auto& b) {
        auto step = b.eval();
        step.template head<2>() = InBody(a.eval(), b.template head<2>());
        step[2] = Wrapped(b[2] - a[2] - z[2]);
        step.template head<2>() -= z.head<2>();
        return step;
      },
      kOdometry, from, to);
}

void AddRangeBearing(dn::Network* net, PoseBlock pose, Landmark landmark,
                     const Eigen::Vector2d& z) {
  net->Add(
      [=](const auto& x, const auto& l) {
        using std::atan2;
        auto r = InBody(x.eval(), l);
        const auto range = r.norm();
        r = decltype(r)(range - z[0], Wrapped(atan2(r[1], r[0]) - z[1]));
        return r;
      },
      kRangeBearing, pose, landmark);
}

Eigen::Vector3d Moved(const Eigen::Vector3d& pose, const Eigen::Vector3d& step) {
  const Eigen::Vector2d p = pose.head<2>() + Eigen::Rotation2Dd(pose[2]) * step.head<2>();
  return {p.x(), p.y(), pose[2] + step[2]};
}

}  // namespace

int main() {
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  const std::vector<Eigen::Vector2d> truth{{-5, -5}, {25, -5}, {25, 25}, {-5, 25}, {10, 10}};
  dn::Network net;
  std::vector<Landmark> landmarks;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector2d start = truth[i] + Eigen::Vector2d(normal(rng), normal(rng));
    landmarks.push_back(net.AddVector<2>("landmark " + std::to_string(i), start));
  }

  Eigen::Vector3d pose = Eigen::Vector3d::Zero(), predicted = pose;
  PoseBlock last = net.AddVector<3>("pose 0", pose);
  net.Hold(last);
  for (int k = 1; k <= 40; ++k) {
    const Eigen::Vector3d step(2.0, 0.0, k % 10 == 0 ? M_PI / 2 : 0.0);
    const Eigen::Vector3d odometry =
        step + Eigen::Vector3d(0.05 * normal(rng), 0.05 * normal(rng), 0.01 * normal(rng));
    pose = Moved(pose, step);
    predicted = Moved(predicted, odometry);
    const PoseBlock next = net.AddVector<3>("pose " + std::to_string(k), predicted);
    AddOdometry(&net, last, next, odometry);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Eigen::Vector2d b = InBody(pose, truth[i]);
      AddRangeBearing(&net, next, landmarks[i],
                      {b.norm() + 0.1 * normal(rng), std::atan2(b[1], b[0]) + 0.01 * normal(rng)});
    }
    last = next;
  }

  const dn::SolveSummary report = dn::Solve(net);
  const dn::Marginals marginals(net);
  bool good = report.converged && Between("sigma0", report.adjusted.sigma0(), 0.85, 1.15);
  for (int i = 0; i < 3; ++i) {
    good = Agrees("last pose", net.Value(last)[i], pose[i], marginals.Sigma(last)[i]) && good;
  }
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const Eigen::Vector2d sigma = marginals.Sigma(landmarks[k]);
    good = Agrees("landmark x", net.Value(landmarks[k]).x(), truth[k].x(), sigma.x()) && good;
    good = Agrees("landmark y", net.Value(landmarks[k]).y(), truth[k].y(), sigma.y()) && good;
  }
  return good ? 0 : 1;
}
