#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

Section Tried(const Facts& report) {
  Table table{"", {"step"}, {}};
  for (const std::string& stage : report["tried"].texts()) table.rows.push_back({Text(stage)});
  if (table.rows.empty()) return {};
  table.note = "The last step failed.";
  return {"What was tried", {std::move(table)}};
}

Section Known(const Facts& report) {
  Section section{"What is known of the data", {}};
  for (const std::string& warning : report["warnings"].texts()) {
    section.contents.emplace_back(Paragraph{warning, Tone::kDoubtful});
  }
  Table counts{"Counts", {"", ""}, {}};
  for (const std::string& name : report["counts"].keys()) {
    counts.rows.push_back(Row(name, {report["counts"][name].Count()}));
  }
  if (!counts.rows.empty()) section.contents.emplace_back(std::move(counts));
  return section;
}

}  // namespace

Document RefusalPage(const ResultFolder& folder) {
  const Facts& report = folder.report();
  const std::string flight = report["flight"].text();
  Document document = Begin(folder, flight.empty() ? "dn" : flight, "refusal");
  Headline headline{"refused", "The command has no result.", Tone::kBad};
  headline.reasons = {report["error"]["message"].text()};
  headline.next = {
      "dn check FLIGHT summarises all files, and says what to look at.",
      "dn gap FLIGHT tests causes one by one: clock, antenna, axes, noise.",
      "time_span_s limits a flight to the time whose data fit, to find the time that does not."};
  document.headlines.push_back(std::move(headline));
  Append(Tried(report), &document);
  Append(Known(report), &document);
  return document;
}

}  // namespace dn::page_internal
