#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/montecarlo/summary.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace dn {
namespace {

constexpr double kProbability = 0.99;

TestedStatistic JudgedMeanSquare(double sum2, double dof) {
  return {sum2 / dof, ChiSquareInterval(kProbability, dof)};
}

BoresightConsistency JudgeBoresight(const std::vector<FlightRecord>& records) {
  BoresightConsistency result;
  const auto n = static_cast<double>(records.size());
  double nees = 0.0;
  std::array<long, 3> inside{};
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  for (const FlightRecord& record : records) {
    nees += record.BoresightNees();
    const Eigen::Vector3d sigma = record.boresight_covariance_rad2.diagonal().cwiseSqrt();
    const Eigen::Vector3d e = record.boresight_error_rad.cwiseQuotient(sigma);
    for (std::size_t k = 0; k < 3; ++k) {
      inside[k] += (e.array().abs() <= static_cast<double>(k + 1)).count();
    }
    result.mean_sigmas += e / n;
    square += record.boresight_error_rad.cwiseAbs2() / n;
    result.mean_sigma_deg += sigma * kDegPerRad / n;
  }
  result.rms_deg = square.cwiseSqrt() * kDegPerRad;
  result.nees_per_dof = JudgedMeanSquare(nees, 3.0 * n);
  const auto angles = static_cast<long>(3 * records.size());
  for (std::size_t k = 0; k < 3; ++k) {
    const double p = std::erf(static_cast<double>(k + 1) / std::sqrt(2.0));
    result.coverage[k] = {static_cast<double>(inside[k]) / static_cast<double>(angles),
                          BinomialInterval(kProbability, angles, p)};
  }
  return result;
}

// Returns the number of epochs that all flights have. Their node grids agree, since they depend on
// the common GNSS epochs, but the last epochs may differ.
std::size_t CommonEpochs(const std::vector<FlightRecord>& records) {
  std::size_t n = records.front().epochs.size();
  for (const FlightRecord& record : records) n = std::min(n, record.epochs.size());
  return n;
}

TrajectoryConsistency JudgeTrajectory(const std::vector<FlightRecord>& records, std::size_t q) {
  TrajectoryConsistency result;
  result.quantity = kQuantities[q];
  const auto flights = static_cast<double>(records.size());
  result.band = ChiSquareInterval(kProbability, 3.0 * flights);
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  double outside = 0.0, above = 0.0;
  for (std::size_t k = 0; k < CommonEpochs(records); ++k) {
    double nees = 0.0;
    for (const FlightRecord& record : records) {
      nees += record.epochs[k].nees[q] / (3.0 * flights);
      square += record.epochs[k].sigmas[q].cwiseAbs2() / flights;
    }
    if (!std::isfinite(nees)) continue;
    result.t_s.push_back(records.front().epochs[k].t_s);
    result.nees_per_dof.push_back(nees);
    result.mean_nees_per_dof += nees;
    outside += result.band.Contains(nees) ? 0.0 : 1.0;
    above += nees > result.band.high ? 1.0 : 0.0;
  }
  const auto epochs = static_cast<double>(std::max<std::size_t>(1, result.t_s.size()));
  result.mean_nees_per_dof /= epochs;
  result.share_outside = outside / epochs;
  result.share_above = above / epochs;
  result.rms_sigmas = (square / epochs).cwiseSqrt();
  return result;
}

using SeriesOf = std::vector<SeriesStatistics> FlightRecord::*;

// Residuals depend on common unknowns and are tested together by chi-square. The band of one axis
// uses the axis's expected variance as degrees of freedom.
std::vector<SensorConsistency> JudgeSensors(const std::vector<FlightRecord>& records,
                                            SeriesOf series) {
  struct Sums {
    double square = 0.0, expected = 0.0, count = 0.0, lagged = 0.0;
  };
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, Sums> sums;
  for (const FlightRecord& record : records) {
    for (const SeriesStatistics& s : record.*series) {
      const std::pair key(s.sensor, s.axis);
      if (sums.count(key) == 0) order.push_back(key);
      Sums& sum = sums[key];
      const auto n = static_cast<double>(s.count);
      sum.square += n * s.mean_square;
      sum.expected += n * s.expected_variance;
      sum.count += n;
      sum.lagged += n * s.lag1_correlation;
    }
  }
  std::vector<SensorConsistency> result;
  for (const auto& key : order) {
    const Sums& sum = sums[key];
    if (sum.expected <= 0.0) continue;
    const double half_width = NormalQuantile(0.5 * (1.0 + kProbability)) / std::sqrt(sum.count);
    result.push_back({key.first,
                      key.second,
                      {sum.square / sum.expected, ChiSquareInterval(kProbability, sum.expected)},
                      {sum.lagged / sum.count, {-half_width, half_width}}});
  }
  return result;
}

void AddCost(const std::vector<FlightRecord>& records, MonteCarloSummary* summary) {
  double chi2 = 0.0, redundancy = 0.0;
  long inside = 0;
  for (const FlightRecord& record : records) {
    const auto dof = static_cast<double>(record.redundancy);
    chi2 += record.chi2;
    redundancy += dof;
    inside += ChiSquareInterval(kProbability, dof).Contains(record.chi2 / dof) ? 1 : 0;
  }
  const auto n = static_cast<long>(records.size());
  summary->chi2_per_dof = JudgedMeanSquare(chi2, redundancy);
  summary->share_chi2_inside = {static_cast<double>(inside) / static_cast<double>(n),
                                BinomialInterval(kProbability, n, kProbability)};
}

std::string SeedMessage(const FlightRecord& record, const std::string& message) {
  return "seed " + std::to_string(record.seed) + ": " + message;
}

void AddModelChecks(const std::vector<FlightRecord>& records, MonteCarloSummary* summary) {
  constexpr double kFalseAlarms = 0.001;  // significance level of the model check of one flight
  const auto n = static_cast<long>(records.size());
  for (const FlightRecord& record : records) {
    if (record.contradiction.empty()) continue;
    summary->contradictions.push_back(SeedMessage(record, record.contradiction));
  }
  const auto contradicted = static_cast<double>(summary->contradictions.size());
  summary->share_contradicted = {contradicted / static_cast<double>(n),
                                 {0.0, BinomialInterval(kProbability, n, kFalseAlarms).high}};
}

void AddRms(const std::vector<FlightRecord>& records, MonteCarloSummary* summary) {
  const auto n = static_cast<double>(records.size());
  Eigen::Vector3d p2 = Eigen::Vector3d::Zero(), v2 = p2, rph2 = p2;
  for (const FlightRecord& record : records) {
    p2 += record.position_rms_m.cwiseAbs2() / n;
    v2 += record.velocity_rms_mps.cwiseAbs2() / n;
    rph2 += record.attitude_rms_rad.cwiseAbs2() / n;
    summary->mean_time_s += record.time_s / n;
  }
  summary->position_rms_m = p2.cwiseSqrt();
  summary->velocity_rms_mps = v2.cwiseSqrt();
  summary->attitude_rms_deg = rph2.cwiseSqrt() * kDegPerRad;
}

}  // namespace

bool MonteCarloSummary::consistent() const {
  const auto ok = [](const TestedStatistic& figure) { return figure.ok(); };
  bool all =
      failures == 0 && chi2_per_dof.ok() && share_chi2_inside.ok() && share_contradicted.ok();
  if (with_pairs) {
    all = all && boresight.nees_per_dof.ok() &&
          std::all_of(boresight.coverage.begin(), boresight.coverage.end(), ok);
  }
  return all;
}

MonteCarloSummary Summarise(const std::vector<FlightRecord>& records) {
  MonteCarloSummary summary;
  std::vector<FlightRecord> good;
  for (const FlightRecord& record : records) {
    if (record.failure.empty()) {
      good.push_back(record);
    } else {
      summary.failure_messages.push_back(SeedMessage(record, record.failure));
    }
  }
  summary.flights = static_cast<long>(good.size());
  summary.failures = static_cast<long>(summary.failure_messages.size());
  if (good.empty()) {
    throw InvalidInput("no flight could be adjusted" +
                       (records.empty() ? "" : "; " + summary.failure_messages.front()));
  }
  summary.with_pairs = good.front().with_pairs;
  if (summary.with_pairs) summary.boresight = JudgeBoresight(good);
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    summary.trajectory.push_back(JudgeTrajectory(good, q));
  }
  AddCost(good, &summary);
  AddModelChecks(good, &summary);
  AddRms(good, &summary);
  summary.residuals = JudgeSensors(good, &FlightRecord::residuals);
  summary.innovations = JudgeSensors(good, &FlightRecord::innovations);
  return summary;
}

}  // namespace dn
