#pragma once

#include <dn/files/flight.h>

#include <Eigen/Core>
#include <vector>

namespace dn::diagnosis_internal {

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

}  // namespace dn::diagnosis_internal
