#pragma once

#include <dn/solvers/marginals.h>
#include <dn/solvers/residual_form.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// How a gross error is looked for, row by row (Baarda): a test of size alpha that finds an error
/// of minimal detectable size with probability `power`.
struct RowTest {
  double alpha = 0.001;
  double power = 0.8;

  /// Root of the non-centrality that the test detects: z(1 - alpha / 2) + z(power), 4.13 at the
  /// defaults. Throws InvalidConfig unless both are between 0 and 1.
  double NonCentrality() const;

  /// Smallest error of one row that it finds, in sigmas of the row, of its redundancy number:
  /// NonCentrality / sqrt(redundancy). Infinite for a row that is fitted away.
  double MinimalDetectable(double redundancy) const;
};

/// A row by itself.
struct RowFit {
  LinearizedNetwork::Row row;
  double standardised = 0.0;  ///< Baarda's w: residual / root of its redundancy number
};

/// Residuals of a channel, or of an axis of it, against what their redundancy lets them be.
struct ChannelFit {
  std::string name;             ///< "gnss position", "gnss position east"
  long observations = 0;        ///< rows
  double redundancy = 0.0;      ///< what the fit leaves of them: sum of their redundancy numbers
  double variance_ratio = 1.0;  ///< sum of squares / redundancy
  double p_value = 1.0;         ///< of a ratio this far from 1, either way
  RowFit worst;                 ///< of those that the unknowns do not follow altogether
  double minimal_detectable = 0.0;  ///< RowTest::MinimalDetectable, the median of its rows, sigmas
};

/// Whether the residuals of a network are those that its model would leave.
struct FitCheck {
  double chi2 = 0.0;     ///< sum of squares of all rows
  long redundancy = 0;   ///< rows - parameters
  double sigma0 = 0.0;   ///< sqrt(chi2 / redundancy); 0 without redundancy
  double p_value = 1.0;  ///< of a chi2 this far from its redundancy, either way
  std::vector<ChannelFit> channels;
  RowFit worst;                ///< of all rows
  double worst_p_value = 1.0;  ///< of the largest of as many as there are, by Bonferroni
};

/// Tests a network at the minimum of its cost:
///
///   chi2        r^T r is a chi-square variable of as many degrees of freedom as its redundancy;
///   channels    ChannelForms with MomentsOf, the mean being the sum of redundancy numbers;
///   rows        Baarda's w of each.
///
/// A user's own groups (Network::Tag) are channels like those of a flight. Rows of a robust loss
/// count with its weight; they hide what the loss took out. Throws InvalidInput where `marginals`
/// has no selected inverse.
FitCheck CheckFit(const Marginals& marginals, const RowTest& test = {});

/// One channel of it. `redundancy`: of every row (RedundancyNumbers), `moments` of the form.
ChannelFit DescribeChannel(const LinearizedNetwork& linearized, const ResidualForm& form,
                           const FormMoments& moments, const Eigen::VectorXd& redundancy,
                           const RowTest& test = {});

}  // namespace dn
