#include "study_lines.h"

#include <dn/study/line_choice.h>
#include <fmt/format.h>

#include "config_text.h"

namespace dn::apps {

void RunLineChoice(const LineOptions& options, Run& run) {
  const std::string text = ReadConfigText(options.file);
  const LineCandidates candidates = LineCandidates::Parse(text, options.file);
  const std::string stage = "choosing lines";
  LineSearchOptions search_options;
  search_options.design.threads = run.options().threads;
  search_options.design.seed = options.seed;
  search_options.design.interrupted = [] { return SignalReceived(); };
  search_options.progress = [&](std::size_t studied) {
    run.progress().Stage(stage, fmt::format("{} choices", studied));
  };
  run.progress().Stage(stage);
  const LineSearch search = ChooseLines(candidates, search_options);
  run.report()["seed"] = options.seed;
  run.report()["flight"] = candidates.scenario.name;
  run.report()["counts"] = {{"lines", candidates.names.size()}, {"choices", search.studied.size()}};
  run.AddFile("config.resolved.yaml", text);
  run.AddFile("optimise.json", FormatJson(ToJson(candidates, search)));
  run.AddFile("designs.csv", LineSearchCsv(candidates, search));
  const std::string summary = LineSearchSummary(candidates, search);
  run.AddFile("summary.txt", summary);
  if (search.best >= 0) {
    const LineChoice& best = search.studied[static_cast<std::size_t>(search.best)];
    run.AddFile("plan.yaml", FormatScenario(candidates.With(best.lines)));
  }
  fmt::print("{}", summary);
  if (search.best >= 0) return;
  throw FailedWithResults("target_missed",
                          "the target is not met: " + MissedTarget(candidates, search));
}

}  // namespace dn::apps
