#pragma once

#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "candidate_effects.h"

namespace dn::internal {

/// Consecutive intervals of time; the first and the last are unbounded outwards.
struct TimeCells {
  std::vector<double> start_s;  ///< ascending

  int count() const { return static_cast<int>(start_s.size()); }
  int At(double t_s) const;
  /// Adds `count` cells of equal length from begin_s on.
  void Append(double begin_s, double length_s, int count);
};

/// Returns the strips sorted by their start.
std::vector<StripInterval> InTime(std::vector<StripInterval> strips);

/// Returns the length of boresight cells. Fitting them to the strips changes it by up to a half.
double BoresightCellS(const std::vector<StripInterval>& strips);
/// Returns cells of equal length within each strip: of 15 s, or longer so that about 24 cover all
/// strips.
TimeCells BoresightCells(const std::vector<StripInterval>& strips);

/// Returns the length of GNSS cells in a flight of `length_s` seconds.
double GnssCellS(double length_s);
/// Returns cells of GNSS positions: of 5 s, or 120 cells in a long flight.
TimeCells GnssCells(double begin_s, double length_s);

/// Orthonormal cosines over an interval of time: 1, sqrt(2) cos(pi k s), with s from 0 to 1.
struct Cosines {
  double begin_s = 0.0;
  double length_s = 1.0;
  int count = 1;

  double At(int k, double t_s) const;
  Eigen::VectorXd At(double t_s) const;
  double FrequencyHz(int k) const { return 0.5 * k / length_s; }
  /// Returns the standard deviations of the coefficients of a Gauss-Markov process of unit sigma.
  Eigen::VectorXd GaussMarkov(double tau_s) const;
};

/// Returns a boresight offset that is constant in each cell: three components per cell.
UserEffect BoresightByCell(const TimeCells& cells);

/// Returns the time constants tried for a decaying boresight offset: fractions of the time from the
/// first strip to the end of the last. Slower decay looks like a drift. `strips` must be in order
/// of time.
std::vector<double> SettlingTausS(const std::vector<StripInterval>& strips);

/// Returns a boresight offset that decays from begin_s on: three components per time constant.
UserEffect BoresightSettling(double begin_s, const std::vector<double>& taus_s);

/// Smallest number of strips for which BoresightByHeading differs from a free boresight of each
/// strip.
inline constexpr std::size_t kFewestHeadings = 4;

/// Returns a boresight offset that follows the cosine and the sine of the heading in the middle of
/// each strip: three components each. `strips` and `path` must be in order of time, `path` not
/// empty.
UserEffect BoresightByHeading(const std::vector<StripInterval>& strips,
                              const std::vector<MapPose>& path);

/// Returns a GNSS position offset (map axes) that is constant in each cell: three components per
/// cell.
UserEffect GnssByCell(const TimeCells& cells);

/// Returns a GNSS position offset that is a sum of cosines; the axes are adjacent within each
/// cosine.
UserEffect GnssByCosine(const Cosines& cosines);

}  // namespace dn::internal
