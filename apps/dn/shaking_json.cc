#include "shaking_json.h"

#include <dn/report/json_reader.h>
#include <fmt/format.h>

#include <numbers>

namespace dn::apps {
namespace {

constexpr double kDegPerRadian = 180.0 / std::numbers::pi;

Json AxisList(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

Json ShakingJson(const std::optional<Shaking>& shaking) {
  if (!shaking) return nullptr;
  Json lines = Json::array();
  for (const ShakingLine& line : shaking->lines) {
    lines.push_back({{"frequency_hz", line.frequency_hz},
                     {"rate_deg_s", AxisList(kDegPerRadian * line.rate_radps)},
                     {"accel_m_s2", AxisList(line.accel_mps2)}});
  }
  return {{"calm", shaking->calm()},
          {"low_hz", shaking->low_hz},
          {"high_hz", shaking->high_hz},
          {"rate_deg_s", AxisList(kDegPerRadian * shaking->rate_radps)},
          {"accel_m_s2", AxisList(shaking->accel_mps2)},
          {"lines", lines},
          {"turn_mdeg", 1e3 * kDegPerRadian * shaking->turn_rad},
          {"shift_mm", 1e3 * shaking->shift_m},
          {"coning_deg_h", 3600.0 * kDegPerRadian * shaking->coning_radps},
          {"sculling_mg", shaking->sculling_mps2 / 9.80665e-3}};
}

void PrintShaking(const std::optional<Shaking>& shaking, const char* label) {
  if (!shaking || shaking->calm()) return;
  fmt::print("{}the platform shakes: {}\n", label, Describe(*shaking));
}

}  // namespace dn::apps
