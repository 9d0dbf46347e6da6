#include <dn/diagnosis/beams_output.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <algorithm>

namespace dn {
namespace {

using Kind = BeamUnknown::Kind;

const char* Key(const BeamCorrections& beams) {
  return beams.unknown.kind == Kind::kAngle ? "angle" : "range_offset";
}

const char* Title(const BeamCorrections& beams) {
  return beams.unknown.kind == Kind::kAngle ? "beam angles" : "beam range offsets";
}

Json CorrectionsJson(const BeamCorrections& beams, bool with_values) {
  Json values = Json::array(), observable = Json::array();
  for (std::size_t k = 0; k < beams.value.size(); ++k) {
    observable.push_back(beams.IsObservable(k));
    values.push_back(beams.IsObservable(k) ? Json(beams.value[k]) : Json());
  }
  Json json{{"unit", beams.unit},
            {"sigma", beams.sigma},
            {"prior_sigma", beams.prior_sigma},
            {"observable", observable}};
  if (with_values) json["value"] = values;
  return json;
}

/// Returns "3", "3 and 7", or "3 to 5 and 7".
std::string NumberWords(const std::vector<std::size_t>& numbers) {
  std::vector<std::string> runs;
  for (std::size_t first = 0; first < numbers.size();) {
    std::size_t last = first;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    runs.push_back(last == first ? fmt::format("{}", numbers[first])
                                 : fmt::format("{} to {}", numbers[first], numbers[last]));
    first = last + 1;
  }
  std::string text = runs.front();
  for (std::size_t k = 1; k < runs.size(); ++k) {
    text += (k + 1 == runs.size() ? " and " : ", ") + runs[k];
  }
  return text;
}

/// Says which beams are not observable and why; empty if all are.
std::string Refusal(const BeamCorrections& beams) {
  std::vector<std::size_t> without_pairs, weak;
  for (const std::size_t k : beams.NotObservable()) {
    (beams.unknown.ends[k] == 0 ? without_pairs : weak).push_back(k);
  }
  std::string text;
  const auto add = [&](const std::vector<std::size_t>& numbers, const char* reason) {
    if (numbers.empty()) return;
    text += fmt::format("  not observable: beam{} {}: {}\n", numbers.size() > 1 ? "s" : "",
                        NumberWords(numbers), reason);
  };
  add(without_pairs, "no point of it was used");
  add(weak, "the data say less about it than the prior of lidar.beams");
  return text;
}

std::string CorrectionLines(const BeamCorrections& beams, bool with_values) {
  constexpr std::size_t kPerLine = 4;
  std::string text = fmt::format(
      "{}{} [{}], {}\n", Title(beams), beams.scanner.empty() ? "" : " of scanner " + beams.scanner,
      beams.unit,
      with_values ? "correction relative to their mean" : "sigma relative to their mean");
  for (std::size_t k = 0; k < beams.value.size(); ++k) {
    if (k % kPerLine == 0) text += fmt::format("{}  {:>4}:", k == 0 ? "" : "\n", k);
    std::string cell = fmt::format("{:.2g}", beams.sigma[k]);
    if (with_values) cell = FormatWithSigma(beams.value[k], beams.sigma[k]);
    text += fmt::format(" {:>20}", beams.IsObservable(k) ? cell : "-");
  }
  return text + "\n" + Refusal(beams);
}

}  // namespace

std::optional<BeamErrors> ObservedErrors(const std::vector<BeamCorrections>& beams,
                                         const LidarConfig& lidar) {
  if (beams.empty()) return std::nullopt;
  BeamErrors errors{lidar.scan_axis_s, {}, {}};
  for (const BeamCorrections& each : beams) {
    std::vector<double>& values =
        each.unknown.kind == Kind::kAngle ? errors.angle_rad : errors.range_m;
    for (std::size_t k = 0; k < each.value.size(); ++k) {
      values.push_back(each.IsObservable(k) ? each.value[k] / each.per_si : 0.0);
    }
  }
  return errors;
}

void AddBeamsJson(const std::vector<BeamCorrections>& beams, bool with_values, Json* json) {
  if (beams.empty()) return;
  Json& scanners = (*json)["beams"] = Json::array();
  for (const BeamCorrections& each : beams) {
    if (scanners.empty() || scanners.back()["scanner"] != each.scanner) {
      scanners.push_back({{"scanner", each.scanner}, {"ends", each.unknown.ends}});
    }
    scanners.back()[Key(each)] = CorrectionsJson(each, with_values);
  }
}

std::string BeamsSummary(const std::vector<BeamCorrections>& beams, bool with_values) {
  std::string text;
  for (const BeamCorrections& each : beams) text += CorrectionLines(each, with_values);
  return text;
}

}  // namespace dn
