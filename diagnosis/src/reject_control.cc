#include <dn/builder/use_survey.h>
#include <dn/diagnosis/reject_control.h>

#include <algorithm>
#include <utility>

#include "evidence.h"

namespace dn {
namespace {

using diagnosis_internal::kFamilyLevel;

/// Returns the control point of a network by its name.
const ControlNode& FindNode(const FlightNetwork& network, const std::string& name) {
  return *std::find_if(
      network.control().points().begin(), network.control().points().end(),
      [&](const ControlNode& node) { return network.control().Point(node).name == name; });
}

std::size_t CountObservations(const ControlCheck& control) {
  return static_cast<std::size_t>(std::count_if(
      control.points.begin(), control.points.end(),
      [](const auto& point) { return point.role != ControlPointCheck::Role::kCheck; }));
}

/// Returns whether a constant shift of the control explains more than one wrong point.
bool IsShifted(const ControlCheck& control, const ControlPointCheck& point) {
  return control.shift && control.shift->p_value <= kFamilyLevel &&
         control.shift->statistic > point.statistic;
}

}  // namespace

void RejectWrongControl(const Flight& flight, const AdjustOptions& options,
                        std::optional<Solution>* solution) {
  for (std::size_t rejected = 0;; ++rejected) {
    const std::optional<ControlCheck>& control = (*solution)->model_check().control;
    if (!control || 2 * rejected >= CountObservations(*control)) return;
    const ControlPointCheck* worst = control->Worst(kFamilyLevel);
    if (worst == nullptr || IsShifted(*control, *worst)) return;
    const ControlNode wrong = FindNode((*solution)->network(), worst->name);
    Adjustment adjustment = (*solution)->TakeAdjustment();
    UseSurvey(wrong, false, adjustment.network.get());
    adjustment.control_rejected.push_back(wrong.point);
    solution->reset();
    AdjustAgain(flight, options, &adjustment);
    solution->emplace(std::move(adjustment), options.threads);
  }
}

}  // namespace dn
