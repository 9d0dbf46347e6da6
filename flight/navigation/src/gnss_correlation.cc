#include <dn/navigation/gnss_correlation.h>
#include <dn/solvers/residual_form.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "positions_in_use.h"

namespace dn {
namespace {

constexpr double kFamilyLevel = 1e-3;
constexpr std::size_t kFewestPositions = 20;
constexpr double kShortestInEpochs = 2.0;
constexpr double kLongestShareOfFlight = 0.2;

using navigation_internal::PositionInUse;

/// Returns the scores y for every axis (rows) and position (columns).
Eigen::Matrix3Xd Scores(const std::vector<PositionInUse>& positions,
                        const Eigen::Ref<const Eigen::VectorXd>& residual) {
  Eigen::Matrix3Xd y(3, positions.size());
  for (std::size_t k = 0; k < positions.size(); ++k) {
    y.col(static_cast<Eigen::Index>(k)) =
        positions[k].L.transpose() * residual.segment<3>(positions[k].first_row);
  }
  return y;
}

std::vector<double> Taus(const std::vector<PositionInUse>& positions) {
  const double span_s = positions.back().t_s - positions.front().t_s;
  const double step_s = navigation_internal::MedianInterval(positions);
  std::vector<double> taus_s;
  for (double tau_s = kShortestInEpochs * step_s; tau_s <= kLongestShareOfFlight * span_s;
       tau_s *= 2.0) {
    taus_s.push_back(tau_s);
  }
  return taus_s;
}

/// Returns y^T K y for each axis with K = exp(-dt / tau), summed by a recursion over the epochs.
Eigen::Array3d Energy(const std::vector<PositionInUse>& positions, const Eigen::Matrix3Xd& y,
                      double tau_s) {
  Eigen::Array3d before = Eigen::Array3d::Zero(), sum = Eigen::Array3d::Zero();
  for (Eigen::Index k = 0; k < y.cols(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (k > 0) {
      before = std::exp((positions[at - 1].t_s - positions[at].t_s) / tau_s) *
               (before + y.col(k - 1).array());
    }
    sum += y.col(k).array() * (y.col(k).array() + 2.0 * before);
  }
  return sum;
}

Eigen::Array3d Lag1(const Eigen::Matrix3Xd& y) {
  const Eigen::Index n = y.cols() - 1;
  return y.leftCols(n).cwiseProduct(y.rightCols(n)).rowwise().sum().array() /
         y.array().square().rowwise().sum();
}

/// The scores of one axis, for the data and for samples without time-correlated errors.
struct Axis {
  double square = 0.0;       // y^T y
  Eigen::ArrayXd energy;     // y^T K y of the data, per tau
  Eigen::ArrayXd squares;    // y^T y of each sample
  Eigen::ArrayXXd energies;  // y^T K y: samples x taus

  /// Returns the energy divided by its expectation for the noise level that y^T y indicates.
  Eigen::ArrayXd Ratios() const {
    return energy / square * squares.mean() / energies.colwise().mean().transpose();
  }
  Eigen::ArrayXXd SampleRatios() const {
    return (energies.colwise() / squares * squares.mean()).rowwise() / energies.colwise().mean();
  }

  /// Returns the energies minus their expectation for the noise level that y^T y indicates.
  Eigen::ArrayXd Excess() const {
    return energy - square / squares.mean() * energies.colwise().mean().transpose();
  }

  /// Returns the excess caused by a process of unit variance with the tau at index `of`. Let D be
  /// the covariance of y without the process. The process increases E[y^T A y] by tr(A D K D),
  /// which is half the covariance of y^T A y and y^T K y.
  Eigen::ArrayXd ProcessExcess(Eigen::Index of) const {
    const Eigen::ArrayXd deviation = energies.col(of) - energies.col(of).mean();
    const double of_square = Half(squares, deviation);
    Eigen::ArrayXd excess(energy.size());
    for (Eigen::Index i = 0; i < energy.size(); ++i) {
      excess[i] =
          Half(energies.col(i), deviation) - of_square / squares.mean() * energies.col(i).mean();
    }
    return excess;
  }

  static double Half(const Eigen::ArrayXd& values, const Eigen::ArrayXd& deviation) {
    return 0.5 * ((values - values.mean()) * deviation).sum() /
           static_cast<double>(values.size() - 1);
  }
};

/// Fitted variance of a process on one axis, and the weighted sum of squared residuals of the fit.
struct Fit {
  double variance_m2 = 0.0;
  double misfit = 0.0;
};

/// Fits the variance to the excess at all tau by least squares. The sigmas are proportional to the
/// energies.
Fit FitProcess(const Axis& axis, Eigen::Index of) {
  const Eigen::ArrayXd excess = axis.Excess(), unit = axis.ProcessExcess(of);
  const Eigen::ArrayXd spread =
      (axis.SampleRatios() - 1.0).square().colwise().mean().sqrt().transpose();
  const Eigen::ArrayXd sigma =
      axis.energies.colwise().mean().transpose() * spread * axis.Ratios().max(1.0);
  const Eigen::ArrayXd y = excess / sigma, x = unit / sigma;
  Fit fit;
  fit.variance_m2 = std::max(0.0, (x * y).sum() / (x * x).sum());
  fit.misfit = (y - fit.variance_m2 * x).square().sum();
  return fit;
}

class Tester {
 public:
  Tester(const FlightNetwork& network, const Marginals& marginals)
      : positions_(navigation_internal::PositionsInUse(network, marginals.linearized())) {
    if (positions_.size() < kFewestPositions) return;
    taus_s_ = Taus(positions_);
    TakeData(marginals.linearized().residual());
    ForEachSampledResidual(marginals, [&](const auto& residual) { TakeSample(residual); });
  }

  GnssCorrelation Run() {
    if (taus_s_.empty()) return {};
    result_.lag1_expected = lag1_of_samples_ / static_cast<double>(axes_[0].squares.size());
    Eigen::ArrayXd ratios = Eigen::ArrayXd::Zero(NumTaus());
    Eigen::ArrayXXd of_samples = Eigen::ArrayXXd::Zero(axes_[0].squares.size(), NumTaus());
    for (int a = 0; a < 3; ++a) {
      result_.p_value[a] = PValue(axes_[a].Ratios(), axes_[a].SampleRatios());
      ratios += axes_[a].Ratios();
      of_samples += axes_[a].SampleRatios();
    }
    result_.p_value_together = PValue(ratios, of_samples);
    FindProcess();
    return result_;
  }

 private:
  Eigen::Index NumTaus() const { return static_cast<Eigen::Index>(taus_s_.size()); }

  /// Returns the p-value of the largest ratio of all tau, corrected for the family of every axis
  /// and all together.
  double PValue(const Eigen::ArrayXd& ratios, const Eigen::ArrayXXd& of_samples) const {
    double least = 1.0;
    for (Eigen::Index i = 0; i < ratios.size(); ++i) {
      const Eigen::ArrayXd sample = of_samples.col(i);
      const FormMoments moments = SampleMoments({sample.begin(), sample.end()});
      least = std::min(least, moments.UpperTail(ratios[i]));
    }
    return std::min(1.0, least * 4.0 * static_cast<double>(ratios.size()));
  }

  void FindProcess() {
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < NumTaus(); ++i) {
      std::array<Fit, 3> fits;
      double misfit = 0.0;
      for (std::size_t a = 0; a < 3; ++a) {
        fits[a] = FitProcess(axes_[a], i);
        misfit += fits[a].misfit;
      }
      if (misfit >= least) continue;
      least = misfit;
      result_.process.tau_s = taus_s_[static_cast<std::size_t>(i)];
      for (int a = 0; a < 3; ++a) {
        result_.process.sigma_enu_m[a] = std::sqrt(fits[static_cast<std::size_t>(a)].variance_m2);
      }
    }
  }

  void TakeData(const Eigen::VectorXd& residual) {
    const Eigen::Matrix3Xd y = Scores(positions_, residual);
    result_.lag1 = Lag1(y);
    for (int a = 0; a < 3; ++a) {
      axes_[a].square = y.row(a).squaredNorm();
      axes_[a].energy = Energies(y).row(a);
    }
  }

  void TakeSample(const Eigen::Ref<const Eigen::VectorXd>& residual) {
    const Eigen::Matrix3Xd y = Scores(positions_, residual);
    lag1_of_samples_ += Lag1(y).matrix();
    const Eigen::Array3Xd energies = Energies(y);
    for (int a = 0; a < 3; ++a) {
      Axis& axis = axes_[a];
      const Eigen::Index k = axis.squares.size();
      axis.squares.conservativeResize(k + 1);
      axis.energies.conservativeResize(k + 1, NumTaus());
      axis.squares[k] = y.row(a).squaredNorm();
      axis.energies.row(k) = energies.row(a);
    }
  }

  Eigen::Array3Xd Energies(const Eigen::Matrix3Xd& y) const {
    Eigen::Array3Xd energies(3, NumTaus());
    for (Eigen::Index i = 0; i < NumTaus(); ++i) {
      energies.col(i) = Energy(positions_, y, taus_s_[static_cast<std::size_t>(i)]);
    }
    return energies;
  }

  std::vector<PositionInUse> positions_;
  std::vector<double> taus_s_;
  std::array<Axis, 3> axes_;
  Eigen::Vector3d lag1_of_samples_ = Eigen::Vector3d::Zero();
  GnssCorrelation result_;
};

}  // namespace

bool GnssCorrelation::significant() const {
  return std::min(p_value_together, p_value.minCoeff()) < kFamilyLevel &&
         process.sigma_enu_m.maxCoeff() > 0.0;
}

GnssCorrelation TestGnssCorrelation(const FlightNetwork& network, const Marginals& marginals) {
  return Tester(network, marginals).Run();
}

}  // namespace dn
