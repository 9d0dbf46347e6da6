#include <dn/axis_names.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>
#include <dn/study/line_choice.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "csv_field.h"

namespace dn {
namespace {

std::vector<std::string> LineNames(const LineCandidates& candidates, const LineChoice& choice) {
  std::vector<std::string> names;
  for (const std::size_t k : choice.lines) names.push_back(candidates.names[k]);
  return names;
}

std::string Joined(const std::vector<std::string>& names, const char* by) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : by) + name;
  return text;
}

Json Triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json ToJson(const LineCandidates& candidates, const LineChoice& choice) {
  Json json = {{"lines", LineNames(candidates, choice)}, {"flight_time_s", choice.flight_time_s}};
  json["sigma_deg"] =
      choice.failure.empty() ? Triple(kDegPerRad * choice.sigma_rad) : Json(nullptr);
  if (!choice.failure.empty()) json["singular"] = choice.failure;
  return json;
}

/// Returns the choice nearest to the target for each number of lines.
std::vector<const LineChoice*> BestPerNumber(const LineCandidates& candidates,
                                             const LineSearch& search) {
  std::map<std::size_t, const LineChoice*> best;
  const auto ratio = [&](const LineChoice& choice) {
    return choice.WorstRatio(candidates.target_rad);
  };
  for (const LineChoice& choice : search.studied) {
    const LineChoice*& at = best[choice.lines.size()];
    if (at == nullptr || ratio(choice) < ratio(*at)) at = &choice;
  }
  std::vector<const LineChoice*> rows;
  for (const auto& [number, choice] : best) rows.push_back(choice);
  return rows;
}

std::string Row(const LineCandidates& candidates, const LineChoice& choice, bool best) {
  const std::string head = fmt::format("{} {:>7.0f}", best ? '*' : ' ', choice.flight_time_s);
  const std::string names = Joined(LineNames(candidates, choice), ", ");
  if (!choice.failure.empty()) {
    return fmt::format("{} {:>10} {:>10} {:>10}  {}\n", head, "singular", "", "", names);
  }
  const Eigen::Vector3d deg = kDegPerRad * choice.sigma_rad;
  return fmt::format("{} {:>10.6f} {:>10.6f} {:>10.6f}  {}\n", head, deg.x(), deg.y(), deg.z(),
                     names);
}

}  // namespace

std::string MissedTarget(const LineCandidates& candidates, const LineSearch& search) {
  const LineChoice& all = *std::max_element(
      search.studied.begin(), search.studied.end(),
      [](const LineChoice& a, const LineChoice& b) { return a.lines.size() < b.lines.size(); });
  if (!all.failure.empty()) return all.failure;
  std::string text;
  for (int i = 0; i < 3; ++i) {
    if (all.sigma_rad[i] <= candidates.target_rad[i]) continue;
    text +=
        fmt::format("{}{} {:.2g} instead of {:.2g} deg", text.empty() ? "" : ", ", kRollPitchYaw[i],
                    kDegPerRad * all.sigma_rad[i], kDegPerRad * candidates.target_rad[i]);
  }
  return text;
}

Json ToJson(const LineCandidates& candidates, const LineSearch& search) {
  Json json = {{"schema", "dn.optimise/1"},
               {"target_deg", Triple(kDegPerRad * candidates.target_rad)}};
  json["best"] = nullptr;
  if (search.best >= 0) {
    json["best"] = ToJson(candidates, search.studied[static_cast<std::size_t>(search.best)]);
  }
  json["studied"] = Json::array();
  for (const LineChoice& choice : search.studied) {
    json["studied"].push_back(ToJson(candidates, choice));
  }
  return json;
}

std::string LineSearchSummary(const LineCandidates& candidates, const LineSearch& search) {
  std::string text = fmt::format("{:>9} {:>10} {:>10} {:>10}  {}\n", "time [s]", "roll [deg]",
                                 "pitch", "yaw", "lines");
  const LineChoice* best =
      search.best < 0 ? nullptr : &search.studied[static_cast<std::size_t>(search.best)];
  bool shown = false;
  for (const LineChoice* choice : BestPerNumber(candidates, search)) {
    text += Row(candidates, *choice, choice == best);
    shown = shown || choice == best;
  }
  if (best != nullptr && !shown) text += Row(candidates, *best, true);
  text +=
      fmt::format("{} of {} choices studied; the table has the best one for each number of lines\n",
                  search.studied.size(),
                  (std::size_t{1} << candidates.names.size()) - candidates.names.size() - 1);
  if (best == nullptr) {
    return text + "not even all lines meet the target: " + MissedTarget(candidates, search) + "\n";
  }
  return text + fmt::format("* fly {}: {:.0f} s, the shortest flight that meets the target\n",
                            JoinNames(LineNames(candidates, *best)), best->flight_time_s);
}

std::string LineSearchCsv(const LineCandidates& candidates, const LineSearch& search) {
  std::string text =
      "lines,flight_time_s,sigma_roll_deg,sigma_pitch_deg,sigma_yaw_deg,meets_target,singular\n";
  for (const LineChoice& choice : search.studied) {
    text += CsvField(Joined(LineNames(candidates, choice), " ")) + "," +
            FormatDouble(choice.flight_time_s);
    for (int i = 0; i < 3; ++i) {
      text += ",";
      if (choice.failure.empty()) text += FormatDouble(kDegPerRad * choice.sigma_rad[i]);
    }
    text += choice.WorstRatio(candidates.target_rad) <= 1.0 ? ",1," : ",0,";
    text += CsvField(WithoutControls(choice.failure)) + "\n";
  }
  return text;
}

}  // namespace dn
