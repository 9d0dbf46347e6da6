#pragma once

#include <dn/gap/diagnosis.h>
#include <dn/report/json.h>
#include <dn/report/plot.h>

#include <string>
#include <vector>

namespace dn {

/// gap.json: every number of a diagnosis; angles in mdeg and deg, lengths of user_units and of
/// before and after in mm. What is absent, infinite or not a number is null.
Json GapJson(const GapDiagnosis& diagnosis);

/// What could still hide, as in gap.json: sizes in the units of the table of effects, damage in mdeg.
Json HiddenEffectsJson(const std::vector<HiddenEffect>& effects);

/// Those of any size in one line, then the five that may move the boresight most, a line each.
std::string HiddenEffectsSummary(const std::vector<HiddenEffect>& effects, bool with_boresight);

/// What of the gap no effect explains, in a few words; empty where nothing is left.
std::string UnexplainedWords(const GapDiagnosis& diagnosis);

/// What a diagnosis comes to, in a sentence without its full stop, from its numbers: each effect
/// with size, sigma, the move of the boresight and the key of flight.yaml that models it.
std::string VerdictSentence(const GapDiagnosis& diagnosis);

/// A diagnosis on one screen: verdict, size of the gap, where, causes, before and after, and what
/// could still hide.
std::string GapSummary(const GapDiagnosis& diagnosis);

/// A plot of a diagnosis, for DrawSvg.
struct GapPlot {
  std::string file;
  std::string title;
  std::string x_label;
  std::vector<PlotPanel> panels;
};

/// Ranking of the causes, fingerprint, before and after: those that the diagnosis has numbers for.
std::vector<GapPlot> GapPlots(const GapDiagnosis& diagnosis);

}  // namespace dn
