#include <dn/axis_names.h>
#include <dn/error.h>
#include <dn/names.h>

#include <algorithm>
#include <map>
#include <utility>

#include "calibration.h"
#include "certificate.h"
#include "sections.h"

namespace dn::page_internal {
namespace {

/// Returns what each verdict means for a user of the angles.
const std::map<std::string, Meaning>& VerdictMeanings() {
  static const std::map<std::string, Meaning> meanings{
      {"calibrated",
       {"You may rely on these angles within their sigmas: they are those of the mounting.",
        Tone::kGood,
        {"Georeference with these angles.",
         "dn gap FLIGHT --out DIR lists undetectable effects, and how far they could shift the "
         "angles."}}},
      {"absorbed",
       {"These angles make the cloud consistent, but they contain an error of the trajectory: they "
        "are not those of the mounting.",
        Tone::kDoubtful,
        {"Use them for this flight only, with this trajectory.",
         "For the mounting: calibrate from the raw data (--method dn), or fly with a better "
         "trajectory."}}},
      {"not_observable",
       {"Do not use these angles: the data do not determine them.",
        Tone::kBad,
        {"Fly crossing strips, opposite directions and two heights.",
         "dn study FLIGHT --out DIR says which direction is weak, and which strip would help."}}},
      {"contradicted",
       {"Do not rely on these angles: the data contradict the assumed model.",
        Tone::kBad,
        {"dn gap FLIGHT --out DIR names the cause, and how far adding it closes the gap.",
         "Check what the first reason names: lever arms, clocks, stated noise."}}},
  };
  return meanings;
}

Table Angles(const Facts& boresight) {
  Table table{"Boresight, a rotation vector about the body axes (forward, right, down)",
              {"", "angle [deg]", "sigma [deg]", "sigma [mdeg]"},
              {}};
  for (std::size_t k = 0; k < 3; ++k) {
    table.rows.push_back(Row(kRollPitchYaw[k], {boresight["angles_deg"][k].Decimals(5),
                                                boresight["sigma_deg"][k].Decimals(5),
                                                boresight["sigma_deg"][k].Decimals(2, 1e3)}));
  }
  return table;
}

Table OtherAngles(const Facts& boresight) {
  Table table = AngleTable("In other forms");
  const auto add = [&](const char* name, const char* key) {
    if (boresight[key]) table.rows.push_back(Row(name, Three(boresight[key], 6)));
  };
  add("Euler angles of the order yaw, pitch, roll [deg]", "euler_zyx_deg");
  add("sigma from the normal matrix alone [deg]", "sigma_apriori_deg");
  add("the same, times sigma0 [deg]", "sigma_scaled_deg");
  return table;
}

Table Covariance(const Facts& matrix) {
  Table table = AngleTable("Covariance [mdeg²] of a left perturbation");
  for (std::size_t r = 0; r < 3; ++r) {
    std::vector<Cell> cells;
    for (std::size_t c = 0; c < 3; ++c) cells.push_back(matrix[r][c].Significant(4, 1e6));
    table.rows.push_back(Row(kRollPitchYaw[r], std::move(cells)));
  }
  return table;
}

/// Returns the effects outside of the model with the largest parts in the sigmas.
Table Contributions(const Facts& boresight) {
  constexpr std::size_t kMost = 8;
  Table table = ContributionTable(boresight, kMost);
  table.title = "What the sensors leave unsaid: its part in the sigmas";
  table.note =
      "These effects, within the tolerance of data sheets, are unknowns with priors. The part "
      "of a sigma is what exact knowledge of the effect would save. Without all of them the "
      "sigmas are those of the pure model.";
  if (!table.rows.empty()) table.rows.push_back(PureModelRow(boresight));
  return table;
}

Table Estimates(const Facts& estimates) {
  Table table{"Other estimates: corrections to the assumed values",
              {"unknown", "component", "correction", "sigma", "unit"},
              {}};
  for (const std::string& name : estimates.keys()) {
    const Facts one = estimates[name];
    for (std::size_t k = 0; k < one["value"].elements().size(); ++k) {
      table.rows.push_back({Text(name), Text(std::to_string(k + 1)), one["value"][k].Significant(5),
                            one["sigma"][k].Significant(3), Text(one["unit"].text())});
    }
  }
  return table;
}

Section BoresightSection(const Facts& result) {
  const Facts boresight = result["boresight"];
  Section section{"Boresight", {}};
  section.contents.emplace_back(
      Chart{Correlations("Correlation of the angles [%]", AxisNames(kRollPitchYaw),
                         AxisNames(kRollPitchYaw), boresight["correlation"])});
  for (Table table : {Contributions(boresight), OtherAngles(boresight),
                      Covariance(boresight["covariance_deg2"]), Estimates(result["estimates"])}) {
    if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  }
  return section;
}

std::string MethodName(const Facts& result) {
  const std::string method = result["method"].text();
  if (method == "dn") return "dynamic network";
  if (method == "gh") return "Gauss-Helmert adjustment";
  return method == "planes" ? "plane adjustment" : method;
}

/// Returns the pairs of strips of a result by name. Throws InvalidInput for a name that occurs
/// twice.
std::map<std::string, Facts> StripPairsByName(const Facts& result) {
  std::map<std::string, Facts> pairs;
  for (const Facts& of : result["strip_pairs"].elements()) {
    const std::string strips = of["strips"].text();
    if (pairs.emplace(strips, of).second) continue;
    throw InvalidInput("strip_pairs has '" + WithoutControls(strips) + "' twice");
  }
  return pairs;
}

/// Makes the section of swath separations before and after, for each method. With several methods,
/// `before` is that of the first one on a given trajectory: the assumed mounting on the user's
/// trajectory.
Section SeparationByMethod(const std::vector<Calibrated>& all) {
  const auto given = std::find_if(all.begin(), all.end(), [](const Calibrated& one) {
    return one.result["method"].text() == "gh" && one.result["strip_pairs"];
  });
  std::vector<std::map<std::string, Facts>> by_name;
  for (const Calibrated& one : all) by_name.push_back(StripPairsByName(one.result));
  const Facts first = (given == all.end() ? all.front() : *given).result["strip_pairs"];
  std::vector<Separation> separations;
  for (const Facts& pair : first.elements()) {
    const std::string strips = pair["strips"].text();
    separations.push_back({strips, "before", pair["before"]["separation"]});
    for (std::size_t k = 0; k < all.size(); ++k) {
      const auto found = by_name[k].find(strips);
      if (found == by_name[k].end()) continue;
      separations.push_back(
          {strips, "after, " + MethodName(all[k].result), found->second["after"]["separation"]});
    }
  }
  return SeparationSection(separations);
}

void AppendAll(const ResultFolder& folder, const Calibrated& one, bool several,
               Document* document) {
  const std::string of = several ? ", " + MethodName(one.result) : "";
  const auto append = [&](Section section) {
    section.title += of;
    Append(std::move(section), document);
  };
  append(PairSection(folder, one.result, one.suffix));
  append(BoresightSection(one.result));
  append(ScannerSection(one.result));
  append(BeamSection(one.result));
  append(ControlSection(one.result));
  append(ModelCheckSection(one.result));
  append(BiasCorrelationSection(one.result["correlations"]));
  append({"Adjustment", {AdjustmentTable(one.result["adjustment"])}, true});
}

/// Returns which method to use, why others have no result, and the differences of the methods.
Section MethodsSection(const Facts& comparison,
                       const std::vector<std::pair<std::string, Facts>>& named) {
  Section section{"Do the methods agree?", {}};
  const Tone tone = comparison["use"].text().empty() ? Tone::kBad : Tone::kGood;
  section.contents.emplace_back(Paragraph{comparison["why"].text(), tone});
  for (const std::string& note : comparison["notes"].texts()) {
    section.contents.emplace_back(Paragraph{"No result of " + note, Tone::kDoubtful});
  }
  section.contents.emplace_back(DifferenceTable(named));
  return section;
}

}  // namespace

std::vector<Calibrated> CalibrationsIn(const ResultFolder& folder) {
  std::vector<Calibrated> found;
  const auto read = [&](const char* suffix) {
    const std::string file = std::string("result") + suffix + ".json";
    Facts result = folder.Read(file);
    if (result["boresight"]) found.push_back({suffix, std::move(result)});
  };
  for (const char* suffix : {"_dn", "_gh", "_planes"}) read(suffix);
  // With several methods, result.json repeats one of them.
  if (found.empty()) read("");
  return found;
}

Headline CalibrationHeadline(const Calibrated& calibrated, bool with_name) {
  const Facts assessment = calibrated.result["assessment"];
  const std::string verdict = assessment["verdict"].text();
  Headline headline;
  headline.word = verdict + (with_name ? " (" + MethodName(calibrated.result) + ")" : "");
  headline.reasons = FirstReasons(assessment);
  headline.figures = {Angles(calibrated.result["boresight"])};
  Explain(VerdictMeanings(), verdict, &headline);
  return headline;
}

Document CalibrationPage(const ResultFolder& folder) {
  const std::vector<Calibrated> all = CalibrationsIn(folder);
  Document document = Begin(folder, all.front().result["flight"].text(), "boresight calibration");
  const bool several = all.size() > 1;
  std::vector<std::pair<std::string, Facts>> named;
  for (const Calibrated& one : all) {
    document.headlines.push_back(CalibrationHeadline(one, several));
    named.emplace_back(MethodName(one.result), one.result);
  }
  if (several) Append(MethodsSection(folder.Read("comparison.json"), named), &document);
  Append(StripSurfacesSection(folder), &document);
  Append(SeparationByMethod(all), &document);
  for (const Calibrated& one : all) AppendAll(folder, one, several, &document);
  Append(TrajectorySection(folder), &document);
  Append(BiasSection(folder), &document);
  Append(StatisticsSection(folder.report()["innovations"], folder.report()["residuals"]),
         &document);
  document.certificate = Certificate(folder, all.front());
  return document;
}

}  // namespace dn::page_internal
