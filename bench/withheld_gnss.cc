/// withheld_gnss DATA_DIR [FLIGHT...]: leaves out windows of the GNSS data of measured flights and
/// smooths the rest with estimated noise. The trajectory is then compared with the data that were
/// left out. Its figures are in docs/validation/real-data.md.
#include <dn/adjustment/unknown_noise.h>
#include <dn/builder/gnss_factors.h>
#include <dn/diagnosis/solution.h>
#include <dn/imu/unknown_imu.h>
#include <dn/navigation/antenna_derivative.h>
#include <dn/solvers/prediction.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace dn::bench {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// The windows take a quarter of the time; every phase has other windows.
constexpr double kPeriods = 4.0;
constexpr int kPhases = 3;
// Withheld epochs have sigmas larger by this factor.
constexpr double kNoWeight = 1e4;

/// Returns whether a time is inside a window.
bool IsWithheld(double since_begin_s, double length_s, int phase) {
  const double period_s = kPeriods * length_s;
  const double begin_s = period_s * (phase + 0.5) / kPhases;
  const double t_s = std::fmod(since_begin_s - begin_s + 1000.0 * period_s, period_s);
  return since_begin_s > begin_s && t_s < length_s;
}

/// A flight without the epochs in the windows. The last epochs are never withheld.
struct SplitFlight {
  Flight flight;
  std::vector<MapGnssEpoch> withheld;

  SplitFlight(const fs::path& folder, double length_s, int phase) {
    FlightNeeds needs;
    needs.imu = needs.gnss = true;
    flight = ReadFlight(folder, needs);
    flight.config.imu->grade = kUnknownGrade;
    flight.config.imu->model = UnknownImu();
    std::vector<MapGnssEpoch> kept;
    const double begin_s = flight.gnss->epochs.front().t_s, end_s = flight.gnss->epochs.back().t_s;
    for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
      const bool is_out =
          epoch.t_s < end_s - length_s && IsWithheld(epoch.t_s - begin_s, length_s, phase);
      (is_out ? withheld : kept).push_back(epoch);
    }
    flight.gnss->epochs = kept;
  }
};

/// Sums over withheld positions, per axis.
struct Score {
  Vector3d error2 = Vector3d::Zero(), variance = Vector3d::Zero(), ratio = Vector3d::Zero();
  long count = 0;

  void Add(const Vector3d& error, const Vector3d& variance_m2) {
    error2 += error.cwiseAbs2();
    variance += variance_m2;
    ratio += error.cwiseAbs2().cwiseQuotient(variance_m2);
    ++count;
  }
};

/// Returns the variance of time-correlated errors that the network does not have as unknowns.
Vector3d ProcessVariance(const Solution& solution, const GnssConfig& gnss) {
  const GnssCorrelation& found = solution.adjustment().gnss_correlation;
  if (!gnss.processes.empty() || !found.significant()) return Vector3d::Zero();
  return found.process.sigma_enu_m.cwiseAbs2();
}

/// Adds the withheld epochs with such sigmas that they have no weight, and without velocities.
void AddWithoutWeight(const std::vector<MapGnssEpoch>& withheld, Flight* flight) {
  std::vector<MapGnssEpoch>& epochs = flight->gnss->epochs;
  for (MapGnssEpoch epoch : withheld) {
    const Vector3d default_m2 = flight->config.gnss->sigma_enu_m.cwiseAbs2();
    epoch.covariance_enu_m2 =
        kNoWeight * kNoWeight *
        epoch.covariance_enu_m2.value_or(Eigen::Matrix3d(default_m2.asDiagonal()));
    epoch.velocity_enu_mps.reset();
    epoch.velocity_covariance_enu.reset();
    epochs.push_back(epoch);
  }
  std::ranges::sort(epochs, {}, &MapGnssEpoch::t_s);
}

/// Returns the variance that effects outside of the model add to the position of a node.
Vector3d AddedVariance(const Solution& solution, std::size_t node,
                       const std::vector<TrajectorySigma>& checked) {
  return checked[node].position_enu_m.cwiseAbs2() -
         solution.trajectory().sigma[node].position_enu_m.cwiseAbs2();
}

bool HasNoWeight(const MapGnssEpoch& epoch, const std::vector<MapGnssEpoch>& withheld) {
  return std::ranges::binary_search(withheld, epoch.t_s, {}, &MapGnssEpoch::t_s);
}

void Predict(const SplitFlight& split, Score* score) {
  Flight flight = split.flight;
  AdjustOptions options;
  options.with_pairs = false;
  options.threads = 2;
  EstimateNoise(options, &flight);
  AddWithoutWeight(split.withheld, &flight);
  const Solution solution(flight, options);
  const Vector3d process_m2 = ProcessVariance(solution, *flight.config.gnss);
  const std::vector<TrajectorySigma> checked = solution.CheckedSigmas();
  const FlightNetwork& network = solution.network();
  for (const GnssEdge& edge : network.gnss().edges()) {
    const MapGnssEpoch& epoch = flight.gnss->epochs[edge.epoch];
    if (!HasNoWeight(epoch, split.withheld)) continue;
    const Prediction predicted = PredictFactor(solution.marginals(), edge.position);
    const Eigen::Matrix3d m_from_residual =
        (AntennaDerivative(network, edge, solution.linearized().EvaluateFactorAt(edge.position)) *
         epoch.R_m_enu)
            .inverse();
    const Eigen::Matrix3d of_prediction_m2 = m_from_residual *
                                             (predicted.covariance - Eigen::Matrix3d::Identity()) *
                                             m_from_residual.transpose();
    const Eigen::Matrix3d white_m2 = epoch.R_m_enu.transpose() *
                                     GnssPositionCovariance(epoch, *flight.config.gnss) *
                                     epoch.R_m_enu / (kNoWeight * kNoWeight);
    score->Add(m_from_residual * predicted.residual,
               (of_prediction_m2 + white_m2).diagonal() + process_m2 +
                   AddedVariance(solution, edge.node, checked));
  }
}

void Print(const std::string& name, double length_s, const Score& score) {
  const auto n = static_cast<double>(score.count);
  const Vector3d rms = (score.error2 / n).cwiseSqrt(), sigma = (score.variance / n).cwiseSqrt(),
                 ratio = score.ratio / n;
  fmt::print(
      "{:<12} {:>3.0f} s {:>5} epochs, off by {:.3f} {:.3f} {:.3f} m rms, predicted {:.3f} "
      "{:.3f} {:.3f} m; error^2 / variance {:.2f} {:.2f} {:.2f}, mean {:.2f}\n",
      name, length_s, score.count, rms[0], rms[1], rms[2], sigma[0], sigma[1], sigma[2], ratio[0],
      ratio[1], ratio[2], ratio.mean());
  std::fflush(stdout);
}

void Run(const fs::path& data, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    for (const double length_s : {10.0, 30.0}) {
      Score score;
      for (int phase = 0; phase < kPhases; ++phase) {
        Predict(SplitFlight(data / name, length_s, phase), &score);
      }
      Print(name, length_s, score);
    }
  }
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: withheld_gnss DATA_DIR [FLIGHT...]\n");
    return 2;
  }
  try {
    const std::vector<std::string> names(argv + 2, argv + argc);
    dn::bench::Run(argv[1],
                   names.empty() ? std::vector<std::string>{"thor75", "walk", "psins-car"} : names);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "withheld_gnss: error: {}\n", error.what());
    return 1;
  }
}
