#pragma once

#include <dn/solvers/marginals.h>
#include <dn/solvers/residual_form.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Parameters of the outlier test of single rows (Baarda's data snooping). `alpha` is the
/// significance level, and `power` the probability of detecting an error of the minimal detectable
/// bias.
struct OutlierTest {
  double alpha = 0.001;
  double power = 0.8;

  /// Returns the square root of the non-centrality parameter, z(1 - alpha / 2) + z(power): 4.13 at
  /// the defaults. Throws InvalidConfig unless alpha and power are between 0 and 1.
  double NonCentrality() const;

  /// Returns the minimal detectable bias of one row in sigmas of that row, NonCentrality /
  /// sqrt(redundancy), where `redundancy` is the redundancy number of the row. The result is
  /// infinite for redundancy 0, where the fit absorbs any error.
  double MinimalDetectableBias(double redundancy) const;
};

/// A row with its standardised residual.
struct RowFit {
  LinearizedNetwork::Row row;
  double standardised = 0.0;  ///< Baarda's w: residual / sqrt(redundancy number)
  double redundancy = 0.0;    ///< redundancy number of the row
};

/// Compares the residuals of a channel, or of one axis of it, with their expected size.
struct ChannelFit {
  std::string name;             ///< for example "gnss position", "gnss position east"
  long observations = 0;        ///< number of rows
  double redundancy = 0.0;      ///< sum of the redundancy numbers of the rows
  double variance_ratio = 1.0;  ///< sum of squared residuals / redundancy
  double p_value = 1.0;         ///< two-sided p-value of variance_ratio against 1
  RowFit worst;  ///< row with the largest |w| among the rows that the fit does not absorb
  /// Median of OutlierTest::MinimalDetectableBias over the rows, sigmas.
  double minimal_detectable = 0.0;
};

/// Result of testing whether the residuals of a network agree with its noise model.
struct FitCheck {
  double chi2 = 0.0;     ///< sum of squared residuals of all rows
  long redundancy = 0;   ///< number of rows - number of parameters
  double sigma0 = 0.0;   ///< sqrt(chi2 / redundancy); 0 if the redundancy is 0
  double p_value = 1.0;  ///< two-sided p-value of chi2 with `redundancy` degrees of freedom
  std::vector<ChannelFit> channels;
  RowFit worst;  ///< row with the largest |w| of the network
  /// p-value of `worst` with the Bonferroni correction for the number of rows.
  double worst_p_value = 1.0;
};

/// Tests the residuals of a network at the minimum of its cost:
///
///   chi2        r^T r has a chi-square distribution with `redundancy` degrees of freedom;
///   channels    ChannelForms with ComputeFormMoments; the mean is the sum of the redundancy
///   numbers; rows        Baarda's w of each row.
///
/// A user's own groups (Network::Tag) are channels like those of a flight. Rows with a robust loss
/// count with their robust weight, so outliers that the loss downweights do not show in the test.
/// Throws InvalidInput if the selected inverse of `marginals` has not been computed.
FitCheck CheckFit(const Marginals& marginals, const OutlierTest& test = {});

/// Returns the two-sided p-value of the sum of squares of a channel. `redundancy` is the sum of the
/// redundancy numbers of its rows.
double ChannelPValue(double redundancy, const FormMoments& moments, double energy);

/// Returns the test of one channel for the residuals of the network, or for what they would be with
/// further unknowns. `redundancy` contains the redundancy number of every row of the
/// network (RedundancyNumbers). `moments` are those of `form`.
ChannelFit TestChannel(const LinearizedNetwork& linearized, const Eigen::VectorXd& residual,
                       const ResidualForm& form, const FormMoments& moments,
                       const Eigen::VectorXd& redundancy, const OutlierTest& test = {});

}  // namespace dn
