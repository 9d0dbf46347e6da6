#pragma once

#include <dn/files/flight.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

namespace dn::testing {

/// A simulated flight with its true trajectory and boresight.
class TrueFlight {
 public:
  TrueFlight(const std::filesystem::path& folder, const Eigen::Vector3d& boresight_deg)
      : flight_(ReadFlight(folder, {.pairs = true, .optional = true})),
        mounting_(flight_.config.lidar->mounting) {
    mounting_.boresight_rad = boresight_deg * kRadPerDeg;
  }

  const Flight& flight() const { return flight_; }

  /// Returns the ground point of a laser vector, ECEF, m.
  Eigen::Vector3d Ground(double t_s, const Eigen::Vector3d& u_s) const {
    const MapPose pose = flight_.reference->MapPoseAt(t_s, flight_.frame);
    return flight_.frame.R_me().transpose() *
           (Georeference(pose, mounting_, u_s) + flight_.frame.r0_m());
  }

  /// Returns the laser vector to a ground point.
  Eigen::Vector3d Vector(double t_s, const Eigen::Vector3d& ground_e_m) const {
    const MapPose pose = flight_.reference->MapPoseAt(t_s, flight_.frame);
    return LaserVectorTo(pose, mounting_, flight_.frame.R_me() * ground_e_m - flight_.frame.r0_m());
  }

  /// Returns an epoch at which the scanner sweeps over a ground point; nullopt if it never does.
  std::optional<double> Epoch(const Eigen::Vector3d& ground_e_m) const {
    const auto out_of_plane = [&](double t_s) {
      return flight_.config.lidar->scan_axis_s.dot(Vector(t_s, ground_e_m));
    };
    for (const StripInterval& strip : flight_.pair_strips) {
      for (double t_s = strip.t0_s; t_s + kStepS < strip.t1_s; t_s += kStepS) {
        if (out_of_plane(t_s) * out_of_plane(t_s + kStepS) > 0.0) continue;
        if (Vector(t_s, ground_e_m).norm() > kRangeM) continue;
        double low = t_s, high = t_s + kStepS;
        for (int k = 0; k < 50; ++k) {
          const double middle = 0.5 * (low + high);
          (out_of_plane(low) * out_of_plane(middle) > 0.0 ? low : high) = middle;
        }
        return low;
      }
    }
    return std::nullopt;
  }

 private:
  static constexpr double kStepS = 0.1, kRangeM = 400.0;

  Flight flight_;
  Mounting mounting_;
};

/// Returns pairs between two flights: every `step`-th ground point of the first that the second
/// sees, too. The ground of the second is moved by `apart_e_m`.
inline std::vector<LidarPair> BetweenPairs(const TrueFlight& a, const TrueFlight& b,
                                           std::size_t step, double sigma_m,
                                           const Eigen::Vector3d& apart_e_m, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0.0, sigma_m);
  std::vector<LidarPair> pairs;
  const std::vector<LidarPair>& own = a.flight().pairs->pairs;
  for (std::size_t k = 0; k < own.size(); k += step) {
    const Eigen::Vector3d ground_e_m = a.Ground(own[k].t_i_s, own[k].u_i_s);
    const std::optional<double> t_s = b.Epoch(ground_e_m);
    if (!t_s) continue;
    const Eigen::Vector3d noise_m =
        Eigen::Vector3d::NullaryExpr([&](Eigen::Index) { return normal(generator); });
    LidarPair pair;
    pair.t_i_s = own[k].t_i_s;
    pair.u_i_s = own[k].u_i_s;
    pair.t_j_s = *t_s;
    pair.u_j_s = b.Vector(*t_s, ground_e_m + apart_e_m + noise_m);
    pair.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    pairs.push_back(pair);
  }
  return pairs;
}

}  // namespace dn::testing
