#include "shaking_json.h"

#include <dn/geo/local_frame.h>
#include <dn/report/json_reader.h>
#include <fmt/format.h>

namespace dn::apps {
namespace {

Json AxisList(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

Json ShakingJson(const std::optional<Shaking>& shaking) {
  if (!shaking) return nullptr;
  Json lines = Json::array();
  for (const ShakingLine& line : shaking->lines) {
    lines.push_back({{"frequency_hz", line.frequency_hz},
                     {"rate_deg_s", AxisList(kDegPerRad * line.rate_radps)},
                     {"accel_m_s2", AxisList(line.accel_mps2)}});
  }
  return {{"calm", shaking->calm()},
          {"low_hz", shaking->low_hz},
          {"high_hz", shaking->high_hz},
          {"rate_deg_s", AxisList(kDegPerRad * shaking->rate_radps)},
          {"accel_m_s2", AxisList(shaking->accel_mps2)},
          {"lines", lines},
          {"turn_mdeg", 1e3 * kDegPerRad * shaking->turn_rad},
          {"shift_mm", 1e3 * shaking->shift_m},
          {"coning_deg_h", 3600.0 * kDegPerRad * shaking->coning_radps},
          {"sculling_mg", shaking->sculling_mps2 / 9.80665e-3}};
}

void PrintShaking(const std::optional<Shaking>& shaking, const char* label) {
  if (!shaking || shaking->calm()) return;
  fmt::print("{}the platform shakes: {}\n", label, Describe(*shaking));
}

}  // namespace dn::apps
