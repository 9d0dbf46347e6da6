#pragma once

#include <dn/builder/flight_network.h>
#include <dn/builder/gnss_factors.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

namespace dn::diagnosis_internal {

/// A statistic of the residuals of one channel and axis at one place. A place is a time, a
/// frequency band, a pair of strips, or a range of scan angles or ranges.
struct LocationStatistic {
  std::string sensor;    ///< "gnss", "gyro", "accel", "lidar"
  std::string quantity;  ///< "position east, mean square"
  std::string location;  ///< "strips 1-2"; empty: the whole flight
};

/// Returns a name such as "lidar p2p east, mean, strips 1-2".
std::string StatisticName(const LocationStatistic& statistic);

/// Statistics of the residuals of a flight, place by place. Each residual is divided by the root of
/// its redundancy number. Residuals that the unknowns absorb completely are not used.
class Locations {
 public:
  Locations(const FlightNetwork& network, const LinearizedNetwork& linearized,
            const Eigen::VectorXd& redundancy);

  const std::vector<LocationStatistic>& statistics() const { return statistics_; }

  /// Returns all statistics of residuals r of the network.
  Eigen::VectorXd Evaluate(const Eigen::VectorXd& r) const;

  /// Returns the mean Kullback-Leibler divergence of the residuals from white noise of the stated
  /// size, nats per residual. It is computed for each channel, axis and stretch of time from mean,
  /// variance and correlation of neighbours (Gaussian).
  double SizeNats(const Eigen::VectorXd& r) const;

  /// Returns the rms prediction error of the pair differences, m. Each is predicted from all other
  /// data. Returns 0 without such residuals.
  double PairRms(const Eigen::VectorXd& r) const;
  /// Returns the rms prediction error of the GNSS positions, m, in the same way.
  double GnssRms(const Eigen::VectorXd& r) const;

 private:
  using Terms = std::vector<std::pair<Eigen::Index, double>>;
  struct Series;
  enum class Form { kMean, kSquare, kLag, kBand };
  struct Recipe {
    Form form;
    Terms terms;
    Eigen::MatrixXd cosines;  // for kBand: terms x waves
  };

  void AddSeries(const Series& series);
  void AddWindows(const Series& series);
  void AddBands(const Series& series);
  void AddPairs(const FlightNetwork& network, const LinearizedNetwork& linearized);
  void Add(const LocationStatistic& statistic, Form form, Terms terms);
  double EvaluateRecipe(const Recipe& recipe, const Eigen::VectorXd& r) const;
  double Rms(const Terms& terms, const Eigen::VectorXd& r) const;

  Eigen::VectorXd weight_;  // 1 / root of the redundancy number; 0: not used
  std::vector<LocationStatistic> statistics_;
  std::vector<Recipe> recipes_;
  std::vector<Terms> cells_;  // stretches of time for SizeNats, in order of time
  Terms pair_errors_m_, gnss_errors_m_;
};

}  // namespace dn::diagnosis_internal
