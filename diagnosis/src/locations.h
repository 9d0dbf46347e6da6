#pragma once

#include <dn/builder/edge_factors.h>
#include <dn/builder/flight_network.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

namespace dn::internal {

/// A statistic of the residuals at one place: of a channel, an axis, a time, a frequency band, a pair
/// of strips, a range of scan angles.
struct LocationStatistic {
  std::string sensor;    ///< "gnss", "gyro", "accel", "lidar"
  std::string quantity;  ///< "position east, mean square"
  std::string location;  ///< "strips 1-2"; empty: the whole flight
};

/// "lidar p2p east, mean, strips 1-2".
std::string NameOf(const LocationStatistic& statistic);

/// What the residuals of a flight look like, place by place. A residual counts over the root of its
/// redundancy number; those that the unknowns follow altogether take no part.
class Locations {
 public:
  Locations(const FlightNetwork& network, const LinearizedNetwork& linearized,
            const Eigen::VectorXd& redundancy);

  const std::vector<LocationStatistic>& statistics() const { return statistics_; }

  /// All statistics of the residuals r of the network.
  Eigen::VectorXd Evaluate(const Eigen::VectorXd& r) const;

  /// Mean Kullback-Leibler divergence of the residuals of each channel, axis and stretch of time
  /// from white noise of the stated size (Gaussian, by mean, variance and correlation of
  /// neighbours), nats per residual.
  double SizeNats(const Eigen::VectorXd& r) const;

  /// Root mean square of what all other data predict of a residual against its measured value, m.
  /// 0 where there is no residual of the kind.
  double PairRms(const Eigen::VectorXd& r) const;
  double GnssRms(const Eigen::VectorXd& r) const;

 private:
  using Terms = std::vector<std::pair<Eigen::Index, double>>;
  struct Series;
  enum class Form { kMean, kSquare, kLag, kBand };
  struct Recipe {
    Form form;
    Terms terms;
    Eigen::MatrixXd cosines;  // of kBand: terms x waves
  };

  void AddSeries(const Series& series);
  void AddWindows(const Series& series);
  void AddBands(const Series& series);
  void AddPairs(const FlightNetwork& network, const LinearizedNetwork& linearized);
  void Add(const LocationStatistic& statistic, Form form, Terms terms);
  double ValueOf(const Recipe& recipe, const Eigen::VectorXd& r) const;
  double Rms(const Terms& terms, const Eigen::VectorXd& r) const;

  Eigen::VectorXd weight_;  // 1 / root of the redundancy number, 0: takes no part
  std::vector<LocationStatistic> statistics_;
  std::vector<Recipe> recipes_;
  std::vector<Terms> cells_;  // of SizeNats, in order of time
  Terms pair_errors_m_, gnss_errors_m_;
};

}  // namespace dn::internal
