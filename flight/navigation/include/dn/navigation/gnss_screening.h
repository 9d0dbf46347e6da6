#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <cstddef>
#include <set>
#include <vector>

namespace dn {

/// Tests every GNSS position and velocity of a network, active or not, against its prediction from
/// all other measurements.
class GnssScreening {
 public:
  /// `marginals` must have its selected inverse.
  GnssScreening(const FlightNetwork& network, const Marginals& marginals);

  /// Returns the largest statistic (chi-square of three) of an active epoch.
  double Worst() const;

  /// Returns the ids of the active positions with the largest statistics, at most `count`. A jump
  /// of the positions has large statistics at its two ends.
  std::vector<FactorId> WorstPositions(std::size_t count) const;

  /// Deactivates the measurements with the largest statistics of each neighbourhood if noise cannot
  /// explain them; the others may be affected by these and stay. Activates measurements again that
  /// agree with the others, except those in `out_for_good`. Returns the number of changes. The
  /// threshold grows with the median of the statistics, so that a flight whose sigmas are all too
  /// small keeps its measurements. `noise_ratio`: variance of white noise and time-correlated
  /// errors together, divided by the variance of the white noise.
  long Apply(const std::set<FactorId>& out_for_good, double noise_ratio, Network* net) const;

 private:
  struct Judged {
    FactorId id;
    double statistic;
    bool active;
  };
  static std::vector<Judged> Judge(const FlightNetwork& network, const Marginals& marginals,
                                   FactorId GnssEdge::*which);
  static double WorstNearby(const std::vector<Judged>& judged, std::size_t k);
  static long Apply(const std::vector<Judged>& judged, const std::set<FactorId>& out_for_good,
                    double noise_ratio, Network* net);

  std::vector<Judged> positions_;
  std::vector<Judged> velocities_;
};

}  // namespace dn
