#include <dn/adjustment/control_checks.h>

#include <cmath>

namespace dn {
namespace {

constexpr double kNearlyVertical = 0.98;  // a slope of 11 deg

/// Sums over checks.
struct Sums {
  int checks = 0;
  double residual = 0.0, squares = 0.0, survey = 0.0;

  std::optional<ControlAccuracy> Accuracy(bool with_mean) const {
    if (checks == 0) return std::nullopt;
    const double n = checks;
    return ControlAccuracy{checks, with_mean ? residual / n : 0.0, std::sqrt(squares / n),
                           std::sqrt(survey / n)};
  }
};

}  // namespace

const char* Word(ControlPointCheck::Role role) {
  using Role = ControlPointCheck::Role;
  switch (role) {
    case Role::kObservation:
      return "observation";
    case Role::kCheck:
      return "check";
    case Role::kRejected:
      break;
  }
  return "rejected";
}

bool ControlPointCheck::vertical() const {
  return directions_enu.cols() == 3 || directions_enu(2, 0) >= kNearlyVertical;
}

bool ControlPointCheck::horizontal() const { return directions_enu.cols() == 3; }

double ControlAccuracy::combined_m() const { return std::hypot(rmse_m, survey_m); }

void ControlCheck::ComputeAccuracy() {
  Sums up, level;
  double squares = 0.0;
  check_components = 0;
  for (const ControlPointCheck& point : points) {
    if (point.role != ControlPointCheck::Role::kCheck) continue;
    squares += point.statistic;
    check_components += point.dof;
    if (point.vertical()) {
      const Eigen::Index k = point.residual_m.size() - 1;
      ++up.checks;
      up.residual += point.residual_m[k];
      up.squares += std::pow(point.residual_m[k], 2);
      up.survey += std::pow(point.survey_sigma_m[k], 2);
    }
    if (point.horizontal()) {
      ++level.checks;
      level.squares += point.residual_m.head<2>().squaredNorm();
      level.survey += point.survey_sigma_m.head<2>().squaredNorm();
    }
  }
  vertical = up.Accuracy(true);
  horizontal = level.Accuracy(false);
  if (check_components > 0) variance_of_checks = squares / check_components;
}

const ControlPointCheck* ControlCheck::Worst(double level) const {
  const ControlPointCheck* worst = nullptr;
  for (const ControlPointCheck& point : points) {
    if (point.role != ControlPointCheck::Role::kObservation || point.p_value > level) continue;
    if (worst == nullptr || point.statistic / point.dof > worst->statistic / worst->dof) {
      worst = &point;
    }
  }
  return worst;
}

}  // namespace dn
