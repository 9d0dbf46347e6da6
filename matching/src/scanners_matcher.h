#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "matcher.h"

namespace dn::matching_internal {

/// Matches the strips of different scanners. Aligned scanners stay as they are. The others turn
/// until their points agree with those of all.
class ScannersMatcher : public Matcher {
 public:
  ScannersMatcher(ScannersMatchSource* source, const MatchOptions& options);

 private:
  double FirstSearch() const override { return loose_.empty() ? 0.0 : ShiftByAngles(); }
  AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) override;
  bool HasBoresight() const override { return !loose_.empty(); }
  /// Returns the boresight of the first scanner that turns; zero if all stay.
  Eigen::Vector3d Boresight() const override;
  /// One pair of strips leaves the boresight of rasters much coarser than that of a flight.
  int MostPilots() const override { return 6; }
  void AsGiven(const std::function<void()>& work) override;
  bool Compares(std::size_t i, std::size_t j) const override;
  bool MustOverlap() const override { return false; }

  FlightMatchSource& Scanner(std::size_t k) const { return *source_.scanners()[k].source; }

  ScannersMatchSource& source_;
  std::vector<std::size_t> loose_;          // scanners that turn
  std::vector<Eigen::Vector3d> given_rad_;  // boresights of the loose_ at first
};

}  // namespace dn::matching_internal
