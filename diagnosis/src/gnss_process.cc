#include "gnss_process.h"

#include <dn/effects/gnss_process_prior.h>
#include <dn/files/flight_config.h>
#include <dn/navigation/antenna_derivative.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "median_sigmas.h"

namespace dn::diagnosis_internal {
namespace {

// The shortest period of the cosines, and their largest number; both bound the time.
constexpr double kShortestCosineS = 30.0;
constexpr int kMostProcessCosines = 30;
// Larger sizes, in standard deviations of their logarithm above the prior, are not usual.
constexpr double kUsualSigmas = 3.0;

EffectModel MakeColumns(const FlightNetwork& network, const LinearizedNetwork& linearized,
                        const Cosines& cosines) {
  EffectModel columns;
  for (const GnssEdge& edge : network.gnss().edges()) {
    if (!linearized.FindRows(edge.position)) continue;
    const Eigen::MatrixXd J =
        AntennaDerivative(network, edge, linearized.EvaluateFactorAt(edge.position)) *
        network.flight().gnss->epochs[edge.epoch].R_m_enu;
    const Eigen::VectorXd weight = cosines.At(network.nodes()[edge.node].t_s);
    EffectPart part{edge.position, Eigen::MatrixXd(J.rows(), 3 * cosines.count)};
    for (int k = 0; k < cosines.count; ++k) part.L.middleCols<3>(3 * k) = weight[k] * J;
    columns.push_back(std::move(part));
  }
  return columns;
}

}  // namespace

std::vector<ProcessSize> GnssProcessBasis::Sizes() const {
  std::vector<ProcessSize> sizes;
  for (const GnssProcessPrior::Size& one : GnssProcessPrior::Sizes()) {
    sizes.push_back({stated_sigma_m * one.size, one.log_probability});
  }
  return sizes;
}

std::vector<ProcessShape> GnssProcessBasis::Shapes() const {
  const std::vector<double> taus_s = GnssProcessPrior::TausS(cosines.length_s);
  std::vector<ProcessShape> shapes;
  for (const double tau_s : taus_s) {
    const Eigen::VectorXd of_cosine = cosines.GaussMarkov(tau_s);
    ProcessShape shape{tau_s, Eigen::VectorXd(3 * of_cosine.size()),
                       -std::log(static_cast<double>(taus_s.size()))};
    for (Eigen::Index k = 0; k < of_cosine.size(); ++k) {
      shape.sigma.segment<3>(3 * k) = of_cosine[k] * GnssProcessPrior::Axes();
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

bool IsUsualSize(const ProcessMixture& process) {
  return process.log_size.mean <
         process.log_size_before.mean + kUsualSigmas * GnssProcessPrior::kLogSizeSigma;
}

std::optional<GnssProcessBasis> AddGnssProcess(const FlightNetwork& network,
                                               const LinearizedNetwork& linearized,
                                               Library* library) {
  if (!HasAutomaticGnssProcess(network.flight().config)) return std::nullopt;
  const std::vector<double>& t_s = network.trajectory().node_times();
  GnssProcessBasis basis;
  basis.cosines.begin_s = t_s.front();
  basis.cosines.length_s = t_s.back() - t_s.front();
  basis.cosines.count = std::clamp(
      static_cast<int>(2.0 * basis.cosines.length_s / kShortestCosineS), 2, kMostProcessCosines);
  EffectModel columns = MakeColumns(network, linearized, basis.cosines);
  if (columns.empty()) return std::nullopt;
  basis.block = library->AddBlock(std::move(columns));
  basis.stated_sigma_m = GnssProcessPrior::StatedSigma(MedianGnssSigma(network.flight()));
  return basis;
}

}  // namespace dn::diagnosis_internal
