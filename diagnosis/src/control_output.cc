#include <dn/diagnosis/control_output.h>
#include <dn/geo/local_frame.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "json_numbers.h"

namespace dn {
namespace {

using Role = ControlPointCheck::Role;

constexpr double kMdegPerRad = kDegPerRad * 1e3;
// The standard asks for this number of checks before an accuracy counts as tested.
constexpr int kChecksOfStandard = 30;

Json PointJson(const ControlPointCheck& point) {
  const Eigen::VectorXd sigma_m = point.covariance_m2.diagonal().cwiseSqrt();
  Json directions = Json::array();
  for (Eigen::Index k = 0; k < point.directions_enu.cols(); ++k) {
    directions.push_back(ToJson(Eigen::Vector3d(point.directions_enu.col(k))));
  }
  return {{"name", point.name},
          {"role", Word(point.role)},
          {"directions_enu", directions},
          {"residual_m", diagnosis_internal::List(point.residual_m)},
          {"sigma_m", diagnosis_internal::List(sigma_m)},
          {"survey_sigma_m", diagnosis_internal::List(point.survey_sigma_m)},
          {"normalised", diagnosis_internal::List(point.normalised())},
          {"statistic", point.statistic},
          {"dof", point.dof},
          {"p_value", point.p_value},
          {"boresight_influence_mdeg", point.role == Role::kObservation
                                           ? ToJson(point.boresight_rad * kMdegPerRad)
                                           : Json(nullptr)}};
}

Json AccuracyJson(const std::optional<ControlAccuracy>& accuracy) {
  if (!accuracy) return nullptr;
  return {{"checks", accuracy->checks},
          {"mean_m", accuracy->mean_m},
          {"rmse_m", accuracy->rmse_m},
          {"survey_m", accuracy->survey_m},
          {"combined_m", accuracy->combined_m()}};
}

Json ShiftJson(const std::optional<ControlShift>& shift) {
  if (!shift) return nullptr;
  return {{"estimated", shift->estimated},
          {"enu_m", ToJson(shift->shift_m)},
          {"sigma_m", ToJson(shift->sigma_m)},
          {"p_value", shift->p_value}};
}

std::string PointLine(const ControlPointCheck& point) {
  std::vector<std::string> values;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Index at = point.horizontal() ? k : k - 2;
    const bool given = at >= 0;
    values.push_back(given ? fmt::format("{:>9.3f}", point.residual_m[at])
                           : fmt::format("{:>9}", "-"));
    values.push_back(given ? fmt::format("{:>7.3f}", std::sqrt(point.covariance_m2(at, at)))
                           : fmt::format("{:>7}", "-"));
  }
  const double influence_mdeg = point.boresight_rad.cwiseAbs().maxCoeff() * kMdegPerRad;
  return fmt::format(
      "  {:<12} {:<11}{} {:>7.2f} {:>9}\n", point.name.substr(0, 12), Word(point.role),
      fmt::format("{}", fmt::join(values, "")), point.normalised().cwiseAbs().maxCoeff(),
      point.role == Role::kObservation ? fmt::format("{:.2f}", influence_mdeg) : "-");
}

std::string AccuracyLine(const char* name, const std::optional<ControlAccuracy>& accuracy) {
  if (!accuracy) return {};
  return fmt::format(
      "  {} accuracy {:.3f} m: RMSE of {} checks {:.3f} m, accuracy of the checks {:.3f} m\n", name,
      accuracy->combined_m(), accuracy->checks, accuracy->rmse_m, accuracy->survey_m);
}

}  // namespace

Json ControlJson(const ControlCheck& control) {
  Json points = Json::array();
  for (const ControlPointCheck& point : control.points) points.push_back(PointJson(point));
  return {{"points", points},
          {"datum_shift", ShiftJson(control.shift)},
          {"accuracy",
           {{"standard", "ASPRS edition 2"},
            {"vertical", AccuracyJson(control.vertical)},
            {"horizontal", AccuracyJson(control.horizontal)},
            {"enough_checks", control.vertical && control.vertical->checks >= kChecksOfStandard}}},
          {"checks_variance", diagnosis_internal::Number(control.variance_of_checks)},
          {"checks_components", control.check_components}};
}

std::string ControlSummary(const ControlCheck& control) {
  std::string text = fmt::format(
      "control, laser minus survey without the point itself [m]; planes and heights: along the "
      "normal\n  {:<12} {:<11}{:>9}{:>7}{:>9}{:>7}{:>9}{:>7} {:>7} {:>9}\n",
      "", "role", "E", "sigma", "N", "sigma", "U", "sigma", "sigmas", "mdeg");
  for (const ControlPointCheck& point : control.points) text += PointLine(point);
  text += "  mdeg: largest change of an angle of the boresight without the point\n";
  if (const auto& shift = control.shift; shift && shift->estimated) {
    text += fmt::format("  datum shift E {}, N {}, U {} m\n",
                        FormatWithSigma(shift->shift_m.x(), shift->sigma_m.x()),
                        FormatWithSigma(shift->shift_m.y(), shift->sigma_m.y()),
                        FormatWithSigma(shift->shift_m.z(), shift->sigma_m.z()));
  }
  text += AccuracyLine("vertical", control.vertical);
  text += AccuracyLine("horizontal", control.horizontal);
  if (control.vertical && control.vertical->checks < kChecksOfStandard) {
    text += fmt::format("  ASPRS (edition 2) asks for at least {} checks to call this tested\n",
                        kChecksOfStandard);
  }
  return text;
}

}  // namespace dn
