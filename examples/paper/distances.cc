#include "distances.h"

#include <dn/study/study.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <string>

namespace paper {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A published boresight in mdeg (roll, pitch, yaw): its distance from the reference and its stated
/// sigma. `set` is the scenario with the same geometry and sensors.
struct PublishedBoresight {
  const char* method;
  const char* set;
  std::array<double, 3> distance, sigma;
};

constexpr std::array<PublishedBoresight, 12> kBoresights{{
    {"network", "lar3", {5, -4, -2}, {.9, .3, .3}},
    {"network", "uav3", {-3, -30, 18}, {13, 3, 4}},
    {"network", "uav2", {-26, -17, 90}, {25, 4, 5}},
    {"network", "uav2_cross", {-26, -17, 90}, {25, 4, 5}},
    {"network", "hal4", {-2, 1, -4}, {.13, .12, .54}},
    {"network", "hal2", {-4, 1, -3}, {.38, .17, 1.2}},
    {"planes", "lar3", {15, -3, 6}, {1, 1, 4}},
    {"planes", "lar2_cross", {18, -28, -91}, {2, 1, 5}},
    {"planes", "uav3", {54, -13, 102}, {2, 2, 8}},
    {"planes", "uav2_cross", {54, -3, 122}, {5, 3, 11}},
    {"planes", "har4", {-55, -8, -93}, {1, 1, 1}},
    {"planes", "har2", {-60, -12, -98}, {6, 5, 25}},
}};

constexpr double kMdegPerRad = 1e3 * dn::kDegPerRad;

double Nees3(const Vector3d& distance_mdeg, const Matrix3d& covariance_mdeg2) {
  return distance_mdeg.dot(covariance_mdeg2.ldlt().solve(distance_mdeg)) / 3.0;
}

std::string Words(const Vector3d& mdeg, int digits) {
  return fmt::format("{:.{}f}, {:.{}f}, {:.{}f}", mdeg.x(), digits, mdeg.y(), digits, mdeg.z(),
                     digits);
}

void PrintRow(const PublishedBoresight& row) {
  dn::StudyOptions options;
  options.remedies = false;
  const dn::BoresightResult ours = dn::Study(dn::ReadScenario(row.set), options).boresight;
  const Vector3d distance = Vector3d::Map(row.distance.data());
  const Vector3d stated = Vector3d::Map(row.sigma.data());
  const double scale = kMdegPerRad * kMdegPerRad;
  const Matrix3d reported = scale * ours.covariance_rad2;
  const Matrix3d modelled = scale * ours.as_modelled->covariance_rad2;
  fmt::print("| {} | {} | {} | {} | {:.0f} | {} | {:.1f} | {} | {:.1f} | {:.0f} % |\n", row.set,
             row.method, Words(distance, 0), Words(stated, 1),
             Nees3(distance, stated.cwiseAbs2().asDiagonal()),
             Words(modelled.diagonal().cwiseSqrt(), 1), Nees3(distance, modelled),
             Words(reported.diagonal().cwiseSqrt(), 1), Nees3(distance, reported),
             1e2 * std::sqrt(reported.trace()) / distance.norm());
}

}  // namespace

void PrintDistances() {
  fmt::print(
      "\nDistances of published boresights from their references, in mdeg (roll, pitch, yaw), and "
      "predicted sigmas.\n\n"
      "| set | method | distance | published sigma | NEES / 3 | sigma as modelled | NEES / 3 | "
      "reported sigma | NEES / 3 | rms of the reported sigma / distance |\n"
      "|---|---|---|---|--:|---|--:|---|--:|--:|\n");
  for (const PublishedBoresight& row : kBoresights) PrintRow(row);
}

}  // namespace paper
