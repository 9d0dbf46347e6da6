#include "beam_corrections.h"

#include <dn/files/scanners.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <variant>

namespace dn::adjustment_internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kPasses = 2;

/// Returns the number of ends of each beam; empty if no end names a beam.
std::vector<long> CountByBeam(const std::vector<GaussHelmertEnd*>& ends) {
  std::vector<long> count;
  for (const GaussHelmertEnd* end : ends) {
    if (end->beam < 0) continue;
    const auto beam = static_cast<std::size_t>(end->beam);
    if (beam >= count.size()) count.resize(beam + 1, 0);
    ++count[beam];
  }
  return count;
}

}  // namespace

BeamAdjustment::BeamAdjustment(const Flight& flight, std::vector<GaussHelmertEnd*> ends,
                               const char* what)
    : flight_(flight),
      ends_(std::move(ends)),
      R_bs_nominal_(flight.config.lidar->mounting.R_bs_nominal),
      unknowns_(MakeBeamUnknowns(flight.config, 0, CountByBeam(ends_), what)) {
  if (!any()) return;
  std::vector<std::shared_ptr<const LidarEffect>> effects;
  for (const BeamUnknown& unknown : unknowns_) {
    effects.push_back(std::get<std::shared_ptr<const LidarEffect>>(BeamAction(flight, unknown)));
    size_ += static_cast<Index>(unknown.num_beams());
  }
  effects_ = LidarEffects(std::move(effects));
  for (const GaussHelmertEnd* end : ends_) file_u_b_.push_back(end->u_b);
}

void BeamAdjustment::Run(LaserUnknowns* laser, const std::function<VectorXd()>& adjust) {
  if (!any()) {
    adjust();
    return;
  }
  laser->information = Information();
  laser->start = VectorXd::Zero(size_);
  for (int pass = 0; pass < kPasses; ++pass) {
    SetVectors(laser->start);
    const VectorXd value = adjust();
    if (pass + 1 < kPasses) laser->start = value;
  }
}

void BeamAdjustment::SetVectors(const VectorXd& value) {
  std::vector<const double*> values;
  Index first = 0;
  for (const BeamUnknown& unknown : unknowns_) {
    values.push_back(value.data() + first);
    first += static_cast<Index>(unknown.num_beams());
  }
  for (std::size_t k = 0; k < ends_.size(); ++k) {
    GaussHelmertEnd& end = *ends_[k];
    if (end.beam < 0) continue;
    const LidarReading reading = Corrected(effects_, values.data(), end.t_s,
                                           R_bs_nominal_.transpose() * file_u_b_[k], 0, end.beam);
    end.u_b = R_bs_nominal_ * reading.u_s;
    Index column = end.beam;
    for (std::size_t n = 0; n < unknowns_.size(); ++n) {
      end.laser[n] = {static_cast<int>(column), R_bs_nominal_ * reading.J_u.col(column)};
      column += static_cast<Index>(unknowns_[n].num_beams());
    }
  }
}

Eigen::MatrixXd BeamAdjustment::Information() const {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size_, size_);
  Index first = 0;
  for (const BeamUnknown& unknown : unknowns_) {
    const Eigen::MatrixXd R = BeamPrior(unknown).sqrt_information();
    information.block(first, first, R.rows(), R.rows()) = R.transpose() * R;
    first += R.rows();
  }
  return information;
}

std::vector<BeamCorrections> BeamAdjustment::Corrections(const VectorXd& value,
                                                         const VectorXd& variance) const {
  std::vector<BeamCorrections> all;
  Index row = 0;
  for (const BeamUnknown& unknown : unknowns_) {
    BeamCorrections& beams = all.emplace_back();
    beams.unknown = unknown;
    beams.scanner = ScannerAt(flight_.config, unknown.scanner).name;
    const bool angle = unknown.kind == BeamUnknown::Kind::kAngle;
    beams.unit = angle ? "deg" : "m";
    beams.per_si = angle ? kDegPerRad : 1.0;
    for (std::size_t k = 0; k < unknown.num_beams(); ++k, ++row) {
      beams.value.push_back(beams.per_si * value[row]);
      beams.sigma.push_back(beams.per_si * std::sqrt(std::max(0.0, variance[row])));
      beams.prior_sigma.push_back(beams.per_si * unknown.PriorSigma(k));
    }
  }
  return all;
}

}  // namespace dn::adjustment_internal
