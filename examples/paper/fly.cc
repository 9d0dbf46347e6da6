#include "fly.h"

#include <dn/diagnosis/result_files.h>
#include <dn/diagnosis/solution.h>
#include <dn/geo/trajectory.h>
#include <dn/rotation.h>

#include <stdexcept>

#include "published.h"

namespace paper {
namespace {

constexpr double kTrajectorySpacing_s = 0.01;

dn::TrajectoryConfig StatedAccuracy(const std::string& scenario, const std::string& file) {
  const PublishedSet& published = Published(scenario);
  dn::TrajectoryConfig config;
  config.file = file;
  config.sigma_rp_rad = dn::kRadPerDeg * published.sigma_rp_deg;
  config.sigma_y_rad = dn::kRadPerDeg * published.sigma_y_deg;
  return config;
}

}  // namespace

const PublishedSet& Published(const std::string& name) {
  for (const PublishedSet& set : kPublished) {
    if (name == set.name) return set;
  }
  throw std::invalid_argument("no strip set '" + name + "' in the paper");
}

SmoothedFlight Fly(const dn::Scenario& scenario, std::uint64_t seed,
                   const std::filesystem::path& folder) {
  dn::SimulateOptions options;
  options.seed = seed;
  SmoothedFlight out{dn::Simulate(scenario, options), {}};
  out.sim.flight.config.unmodelled.none = true;  // the paper's model

  dn::AdjustOptions without_lidar;
  without_lidar.with_pairs = false;
  const dn::Solution smoothed(out.sim.flight, without_lidar);
  const std::vector<dn::NavPoint> points =
      dn::DenseTrajectory(smoothed.network(), kTrajectorySpacing_s);

  dn::OutputDirectory files(folder);
  files.Add("trajectory.out", dn::FormatSbet(points));
  files.Add("trajectory_sigma.txt", dn::FormatTrajectorySigma(smoothed.CheckedSigmas()));
  files.Add(
      "trajectory_covariance.txt",
      dn::FormatTrajectoryCovariance(smoothed.PoseCovariance(dn::FindStrips(out.sim.flight))));
  files.Commit();
  const dn::Json errors = dn::ReferenceErrorsJson(out.sim.flight, smoothed.CheckedPoses());
  for (int i = 0; i < 3; ++i) {
    out.rph_rmse_deg[i] = errors["roll_pitch_heading_rmse_deg"][static_cast<std::size_t>(i)];
  }
  dn::TrajectoryNotes notes;
  notes.velocity_from_file = true;
  out.sim.flight.trajectory = dn::Trajectory(points, notes);
  out.sim.flight.config.trajectory =
      StatedAccuracy(scenario.name, std::filesystem::absolute(folder / "trajectory.out"));
  return out;
}

Eigen::Vector3d ErrorDeg(const Eigen::Vector3d& estimate_rad, const Eigen::Vector3d& truth_rad) {
  return dn::kDegPerRad * dn::Log(dn::Exp(estimate_rad) * dn::Exp(truth_rad).conjugate());
}

}  // namespace paper
