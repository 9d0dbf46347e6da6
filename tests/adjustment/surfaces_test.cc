#include <dn/diagnosis/solution.h>
#include <dn/lidar/surface_pairs.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "testing/short_flights.h"
#include "testing/temp_folder.h"

namespace dn::adjustment_test {
namespace {

using Eigen::Vector3d;
using testing::DroneScenario;
using testing::Fly;
using testing::TempFolder;

constexpr double kSigmaM = 0.03;  // of the pairs of DroneScenario

/// Replaces every second pair of a flight by three surface pairs, one per axis of the map.
SimulatedFlight WithSurfaces(SimulatedFlight sim) {
  std::vector<LidarPair> kept;
  std::vector<SurfacePair> surfaces;
  const std::vector<LidarPair>& pairs = sim.flight.pairs->pairs;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (k % 2 == 0) {
      kept.push_back(pairs[k]);
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      surfaces.push_back({pairs[k], Vector3d::Unit(axis), kSigmaM});
    }
  }
  sim.flight.pairs->pairs = kept;
  const TempFolder folder;
  // The three rows of a point differ in one direction only, and would count as repetitions.
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<SurfacePair> of_axis;
    for (std::size_t k = axis; k < surfaces.size(); k += 3) of_axis.push_back(surfaces[k]);
    folder.Write(std::to_string(axis) + ".txt", FormatSurfacePairs(of_axis));
  }
  FlightConfig config = sim.flight.config;
  config.folder = folder.path();
  sim.flight.surfaces.emplace();
  for (int axis = 0; axis < 3; ++axis) {
    config.lidar->surface_pairs = {std::to_string(axis) + ".txt"};
    const ControlData of_axis = ReadSurfaces(config);
    sim.flight.surfaces->points.insert(sim.flight.surfaces->points.end(), of_axis.points.begin(),
                                       of_axis.points.end());
  }
  return sim;
}

SimulatedFlight FlyPure(std::uint64_t seed) {
  SimulatedFlight sim = Fly(DroneScenario(), seed);
  sim.flight.config.unmodelled.none = true;
  return sim;
}

TEST(Surfaces, ThreeDirectionsAreWorthOnePair) {
  const SimulatedFlight all = FlyPure(1), replaced = WithSurfaces(all);
  SimulatedFlight half = replaced;
  half.flight.surfaces.reset();
  const Solution with_pairs(all.flight), with_surfaces(replaced.flight), without(half.flight);
  const Vector3d sigma_rad = with_pairs.Boresight().sigma_rad();
  const Vector3d differs_rad =
      with_surfaces.Boresight().angles_rad - with_pairs.Boresight().angles_rad;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(differs_rad[k] / sigma_rad[k], 0.0, 0.05);
    EXPECT_NEAR(with_surfaces.Boresight().sigma_rad()[k] / sigma_rad[k], 1.0, 0.01);
  }
  EXPECT_GT(without.Boresight().sigma_rad().norm(), 1.01 * sigma_rad.norm());
  const AdjustmentFigures &pairs = with_pairs.trajectory().figures,
                          &surfaces = with_surfaces.trajectory().figures;
  EXPECT_EQ(pairs.redundancy, surfaces.redundancy);
  EXPECT_NEAR(surfaces.chi2 / pairs.chi2, 1.0, 0.01);
  EXPECT_EQ(surfaces.surface_pairs, 3 * (pairs.correspondences - surfaces.correspondences));
}

TEST(Surfaces, WrongOnesAreLeftOut) {
  SimulatedFlight sim = WithSurfaces(FlyPure(2));
  const Solution right(sim.flight);
  std::vector<ControlPoint>& surfaces = sim.flight.surfaces->points;
  for (std::size_t k = 0; k < surfaces.size(); k += 25) {
    surfaces[k].returns[1].u_s *= 1.0 + 1.5 / surfaces[k].returns[1].u_s.norm();
    surfaces[k].plane->normal_m = Vector3d::UnitZ();
  }
  const Solution wrong(sim.flight);
  const AdjustmentFigures& figures = wrong.trajectory().figures;
  EXPECT_EQ(right.trajectory().figures.surface_outliers, 0);
  EXPECT_GE(figures.surface_outliers, 16);
  EXPECT_LE(figures.surface_outliers, 20);
  const Vector3d moved_rad = wrong.Boresight().angles_rad - right.Boresight().angles_rad;
  const Vector3d sigma_rad = right.Boresight().sigma_rad();
  EXPECT_LT(moved_rad.cwiseQuotient(sigma_rad).cwiseAbs().maxCoeff(), 0.5);
  EXPECT_EQ(figures.redundancy, right.trajectory().figures.redundancy - figures.surface_outliers);
}

// A range offset of one strip's returns on the surfaces only: the model check sees that surfaces
// and pairs disagree.
TEST(Surfaces, TheModelCheckSeesTheirErrors) {
  SimulatedFlight sim = WithSurfaces(FlyPure(3));
  for (ControlPoint& surface : sim.flight.surfaces->points) {
    if (surface.plane->normal_m.z() < 0.5) continue;
    surface.returns[1].u_s *= 1.0 + 0.08 / surface.returns[1].u_s.norm();
  }
  const Solution solution(sim.flight);
  EXPECT_NE(solution.CheckedBoresight().verdict, Verdict::kCalibrated);
}

}  // namespace
}  // namespace dn::adjustment_test
