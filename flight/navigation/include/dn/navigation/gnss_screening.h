#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <cstddef>
#include <set>
#include <vector>

namespace dn {

/// Every GNSS position and velocity of a network, in use or not, against what all the other
/// measurements predict for it.
class GnssScreening {
 public:
  /// `marginals` must have its selected inverse.
  GnssScreening(const FlightNetwork& network, const Marginals& marginals);

  /// The largest statistic (chi-square of three) of an epoch in use.
  double Worst() const;

  /// Ids of the positions in use that the others contradict most, at most `count`: a jump shows at
  /// its two ends.
  std::vector<FactorId> WorstPositions(std::size_t count) const;

  /// Takes out the worst ones of each neighbourhood that cannot be noise, since they may have
  /// spoiled the others, and takes those back that agree, but for out_for_good. Returns how many
  /// changed. The threshold grows with the median of the statistics, so that a flight whose sigmas
  /// are too small as a whole keeps its measurements.
  /// `noise_ratio`: variance of white noise and lasting errors together over that of the white noise.
  long Apply(const std::set<FactorId>& out_for_good, double noise_ratio, Network* net) const;

 private:
  struct Judged {
    FactorId id;
    double statistic;
    bool active;
  };
  static std::vector<Judged> Judge(const FlightNetwork& network, const Marginals& marginals,
                                   FactorId FlightNetwork::GnssEdge::*which);
  static double WorstNearby(const std::vector<Judged>& judged, std::size_t k);
  static long Apply(const std::vector<Judged>& judged, const std::set<FactorId>& out_for_good,
                    double noise_ratio, Network* net);

  std::vector<Judged> positions_;
  std::vector<Judged> velocities_;
};

}  // namespace dn
