#include <dn/adjustment/filter_separation.h>
#include <dn/geo/text_table.h>
#include <dn/rotation.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "open_filter.h"

namespace dn {
namespace {

// A filter has aligned once its sigma of heading is below this fraction of the initial sigma. The
// data then give 99 % of its information on heading.
constexpr double kAlignedShare = 0.1;

SeparationAt Difference(const LocalFrame& frame, const MapPose& forward, const MapPose& reverse) {
  const Eigen::Vector3d down_b =
      ToNavPoint(reverse, frame).q_nb.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d turn_b =
      Log(Eigen::Quaterniond(reverse.q_mb.conjugate() * forward.q_mb).normalized());
  return {forward.t_s, frame.R_m_enu(reverse.p_mb).transpose() * (forward.p_mb - reverse.p_mb),
          BodyFromEulerRates(down_b).inverse() * turn_b};
}

}  // namespace

SeparationAt FilterSeparation::Rms() const {
  SeparationAt rms;
  if (epochs.empty()) return rms;
  for (const SeparationAt& at : epochs) {
    rms.position_enu_m += at.position_enu_m.cwiseAbs2();
    rms.rph_rad += at.rph_rad.cwiseAbs2();
  }
  const auto n = static_cast<double>(epochs.size());
  rms.position_enu_m = (rms.position_enu_m / n).cwiseSqrt();
  rms.rph_rad = (rms.rph_rad / n).cwiseSqrt();
  return rms;
}

SeparationAt FilterSeparation::Max() const {
  SeparationAt max;
  for (const SeparationAt& at : epochs) {
    max.position_enu_m = max.position_enu_m.cwiseMax(at.position_enu_m.cwiseAbs());
    max.rph_rad = max.rph_rad.cwiseMax(at.rph_rad.cwiseAbs());
  }
  return max;
}

FilterSeparation SeparateFilters(const Adjustment& adjustment) {
  const adjustment_internal::DiffusePriorFilter filter(adjustment);
  const DirectedRun forward = filter.Run(FilterDirection::kForward);
  const DirectedRun reverse = filter.Run(FilterDirection::kReverse);
  const double aligned_rad = kAlignedShare * adjustment_internal::DiffuseAttitudeSigma().z();
  std::map<double, const FilterState*> later;
  for (std::size_t k = 0; k < reverse.states.size(); ++k) {
    const FilterState& state = reverse.states[k];
    if (reverse.sigma_heading_rad[k] < aligned_rad) later[state.pose.t_s] = &state;
  }
  FilterSeparation separation;
  for (std::size_t k = 0; k < forward.states.size(); ++k) {
    const MapPose& pose = forward.states[k].pose;
    const auto other = later.find(pose.t_s);
    if (other == later.end() || forward.sigma_heading_rad[k] >= aligned_rad) continue;
    separation.epochs.push_back(Difference(filter.flight().frame, pose, other->second->pose));
  }
  return separation;
}

Json SeparationJson(const FilterSeparation& separation) {
  if (separation.epochs.empty()) return nullptr;
  const SeparationAt rms = separation.Rms(), max = separation.Max();
  return {{"epochs", separation.epochs.size()},
          {"rms_enu_m", ToJson(rms.position_enu_m)},
          {"max_enu_m", ToJson(max.position_enu_m)},
          {"rms_rph_deg", ToJson(rms.rph_rad * kDegPerRad)},
          {"max_rph_deg", ToJson(max.rph_rad * kDegPerRad)}};
}

std::string FormatSeparation(const FilterSeparation& separation) {
  std::string text = "# t, forward minus reverse E, N, U [m], roll, pitch, heading [deg]\n";
  for (const SeparationAt& at : separation.epochs) {
    text += FormatDouble(at.t_s);
    for (const double value : at.position_enu_m) text += ", " + FormatDouble(value);
    for (const double value : at.rph_rad) text += ", " + FormatDouble(value * kDegPerRad);
    text += '\n';
  }
  return text;
}

}  // namespace dn
