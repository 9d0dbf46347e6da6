#include <dn/builder/beam_unknowns.h>
#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/lidar/beam_ends.h>

#include <cmath>
#include <utility>

#include "effects/effects.h"

namespace dn {
namespace {

constexpr const char* kAngleName = "lidar_beam_angle";
constexpr const char* kRangeName = "lidar_beam_range";
// Standard deviation of the mean of the corrections relative to that of a correction. The mean is
// another unknown, so that it is held at zero as far as the arithmetic allows.
constexpr double kMeanOverSigma = 1e-3;

/// Returns the number of ends of pairs of each beam of a scanner.
std::vector<long> CountEnds(const Flight& flight, std::size_t scanner, std::size_t beams) {
  if (!flight.pairs) return std::vector<long>(beams, 0);
  return CountBeamEnds(flight.pairs->pairs, scanner, beams).of_beam;
}

}  // namespace

std::size_t BeamUnknown::NumMeasured() const { return NumMeasuredBeams(ends); }

double BeamUnknown::PriorSigma(std::size_t k) const {
  if (ends[k] == 0) return sigma;
  return sigma * std::sqrt(1.0 - 1.0 / static_cast<double>(NumMeasured()));
}

std::vector<BeamUnknown> MakeBeamUnknowns(const FlightConfig& config, std::size_t scanner,
                                          std::vector<long> ends, const char* what) {
  using Kind = BeamUnknown::Kind;
  const std::optional<BeamConfig>& beams = ScannerAt(config, scanner).beams;
  if (!beams) return {};
  if (ends.size() > beams->count) {
    throw InvalidInput(std::string(what) + " has beam " + std::to_string(ends.size() - 1) +
                       ", but its scanner has " + std::to_string(beams->count) +
                       " beams, numbered from 0");
  }
  ends.resize(beams->count, 0);
  std::vector<BeamUnknown> unknowns;
  if (NumMeasuredBeams(ends) == 0) return unknowns;
  const auto add = [&](Kind kind, const char* name, double sigma) {
    if (sigma == 0.0) return;
    unknowns.push_back({kind, scanner, ScannerName(config, name, scanner), sigma, ends});
  };
  add(Kind::kAngle, kAngleName, beams->angle_sigma_rad);
  add(Kind::kRange, kRangeName, beams->range_sigma_m);
  return unknowns;
}

std::vector<BeamUnknown> FindBeamUnknowns(const Flight& flight) {
  std::vector<BeamUnknown> unknowns;
  for (std::size_t k = 0; k < NumScanners(flight.config); ++k) {
    const std::optional<BeamConfig>& beams = ScannerAt(flight.config, k).beams;
    if (!beams) continue;
    for (BeamUnknown& unknown :
         MakeBeamUnknowns(flight.config, k, CountEnds(flight, k, beams->count), "a pair")) {
      unknowns.push_back(std::move(unknown));
    }
  }
  return unknowns;
}

bool IsBeamUnknown(std::string_view name) {
  const std::string_view unknown = name.substr(0, name.find('/'));
  return unknown == kAngleName || unknown == kRangeName;
}

EffectAction BeamAction(const Flight& flight, const BeamUnknown& unknown) {
  const int beams = static_cast<int>(unknown.num_beams());
  EffectAction action =
      unknown.kind == BeamUnknown::Kind::kAngle
          ? builder_internal::BeamAngles(ScannerAt(flight.config, unknown.scanner), beams)
          : builder_internal::BeamRanges(beams);
  if (NumScanners(flight.config) < 2) return action;
  return OnScanner(std::move(action), unknown.scanner);
}

LinearPrior BeamPrior(const BeamUnknown& unknown) {
  const auto n = static_cast<Eigen::Index>(unknown.num_beams());
  const auto measured = static_cast<double>(unknown.NumMeasured());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    if (unknown.ends[static_cast<std::size_t>(k)] > 0) mean[k] = 1.0 / std::sqrt(measured);
  }
  Eigen::MatrixXd R = Eigen::MatrixXd::Identity(n, n);
  R += (1.0 / kMeanOverSigma - 1.0) * mean * mean.transpose();
  return {{VectorKind(static_cast<int>(n))},
          Eigen::VectorXd::Zero(n),
          R / unknown.sigma,
          Eigen::VectorXd::Zero(n)};
}

}  // namespace dn
