#include <dn/error.h>
#include <dn/page/page.h>

#include <utility>

#include "comparison.h"
#include "sections.h"

namespace dn {
namespace page_internal {

Document OtherPage(const ResultFolder& folder) {
  const Facts& report = folder.report();
  const std::string flight = report["flight"].text();
  const std::string name = flight.empty() ? report["scenario"].text() : flight;
  Document document = Begin(folder, name.empty() ? "dn" : name, "result");
  if (const Facts error = report["error"]) {
    document.headlines = {{"failed", error["message"].text(), Tone::kBad}};
  }
  if (const std::string verdict = report["verdict"].text(); !verdict.empty()) {
    const std::size_t colon = verdict.find(": ");
    Headline headline{verdict.substr(0, colon), verdict.substr(colon + 2), Tone::kDoubtful};
    if (headline.word == "ready") headline.tone = Tone::kGood;
    for (const Facts& hint : report["hints"].elements()) {
      headline.reasons.push_back(hint["text"].text());
    }
    for (const std::string& problem : report["problems"].texts()) {
      headline.reasons.push_back(problem);
    }
    document.headlines.push_back(std::move(headline));
  }
  Table commands{"Commands that are possible with this flight", {"command", "", ""}, {}};
  for (const std::string& command : report["commands"].keys()) {
    const bool possible = report["commands"][command]["possible"].flag();
    commands.rows.push_back(
        Row("dn " + command,
            {Text(possible ? "possible" : "not possible", possible ? Tone::kGood : Tone::kDoubtful),
             Text(report["commands"][command]["why"].text())}));
  }
  if (!commands.rows.empty()) Append({"Commands", {std::move(commands)}}, &document);
  for (const char* file : {"table.txt", "summary.txt"}) {
    const std::string text = folder.Text(file);
    if (!text.empty()) Append({"Summary", {Listing{file, text}}}, &document);
  }
  return document;
}

namespace {

Document PageWithoutRun(const ResultFolder& folder) {
  if (folder.Read("result.json")["flights"]) return FleetPage(folder);
  if (!CalibrationsIn(folder).empty()) return CalibrationPage(folder);
  if (folder.Has("smooth.json")) return SmoothPage(folder);
  if (folder.Has("gap.json")) return GapPage(folder);
  if (folder.Has("study.json")) return StudyPage(folder);
  if (folder.Has("monte_carlo.json")) return MonteCarloPage(folder);
  if (folder.Has("allan.json")) return AllanPage(folder);
  if (folder.Has("match.json")) return MatchPage(folder);
  if (folder.Has("georef.json")) return GeorefPage(folder);
  if (folder.Has("blind_check.json")) return BlindPage(folder);
  if (folder.Has("sweep.json")) return SweepPage(folder);
  if (folder.report()["tried"]) return RefusalPage(folder);
  return OtherPage(folder);
}

}  // namespace
}  // namespace page_internal

Document MakePage(const std::filesystem::path& folder) {
  const page_internal::ResultFolder result(folder);
  Document document = page_internal::PageWithoutRun(result);
  for (Section& section : page_internal::RunSections(result)) {
    document.sections.push_back(std::move(section));
  }
  return document;
}

Document MakePage(const std::vector<std::filesystem::path>& folders) {
  if (folders.size() == 1) return MakePage(folders.front());
  return page_internal::ComparisonPage(folders);
}

}  // namespace dn
