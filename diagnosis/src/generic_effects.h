#pragma once

#include <dn/calibration/candidate_effects.h>
#include <dn/flight/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn::internal {

/// Stretches of time, one after the other; the first and the last have no outer end.
struct TimeCells {
  std::vector<double> start_s;  ///< ascending

  int count() const { return static_cast<int>(start_s.size()); }
  int At(double t_s) const;
  /// Adds `count` cells of equal length from begin_s on.
  void Append(double begin_s, double length_s, int count);
};

/// Strips by their beginning.
std::vector<StripInterval> InTime(std::vector<StripInterval> strips);

/// Length that the cells below have before they are fitted to their strips, by up to a half of it.
double BoresightCellS(const std::vector<StripInterval>& strips);
/// Cells of equal length within each strip, of 15 s or, where the strips are long, so many that some
/// two dozens cover them.
TimeCells BoresightCells(const std::vector<StripInterval>& strips);

double GnssCellS(double length_s);
/// Cells of GNSS positions: of 5 s or, in a long flight, 120.
TimeCells GnssCells(double begin_s, double length_s);

/// Orthonormal cosines over a stretch of time: 1, sqrt(2) cos(pi k s), s from 0 to 1.
struct Cosines {
  double begin_s = 0.0;
  double length_s = 1.0;
  int count = 1;

  double At(int k, double t_s) const;
  Eigen::VectorXd At(double t_s) const;
  double FrequencyHz(int k) const { return 0.5 * k / length_s; }
  /// Standard deviations of the coefficients of a Gauss-Markov process of unit sigma.
  Eigen::VectorXd GaussMarkov(double tau_s) const;
};

/// The boresight differs by a constant in each cell: three components per cell.
OwnEffect BoresightByCell(const TimeCells& cells);

/// Time constants at which a boresight is looked for that settles, of strips in time: fractions of the time from the
/// first strip to the end of the last. What is slower is as good as a drift.
std::vector<double> SettlingTausS(const std::vector<StripInterval>& strips);

/// A part of the boresight decays from begin_s on, with each of the time constants: three components
/// each.
OwnEffect BoresightSettling(double begin_s, const std::vector<double>& taus_s);

/// Over up to three strips cosine and sine are any boresight that each strip has for itself.
inline constexpr std::size_t kFewestHeadings = 4;

/// The boresight follows the cosine and the sine of the heading that each strip has in its middle:
/// three components each. Strips and path in time; the path is not empty.
OwnEffect BoresightByHeading(const std::vector<StripInterval>& strips,
                             const std::vector<MapPose>& path);

/// GNSS positions are off by a constant (map axes) in each cell: three components per cell.
OwnEffect GnssByCell(const TimeCells& cells);

/// GNSS positions are off by a sum of cosines: axis by axis within each cosine.
OwnEffect GnssByCosine(const Cosines& cosines);

}  // namespace dn::internal
