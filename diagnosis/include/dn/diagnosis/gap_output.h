#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/report/json.h>
#include <dn/report/plot.h>

#include <string>
#include <vector>

namespace dn {

/// Returns gap.json with every number of a diagnosis: angles in mdeg and deg, lengths of user_units
/// and of before and after in mm. Absent and non-finite values become null.
Json GapJson(const GapDiagnosis& diagnosis);

/// Returns the detection limits as in gap.json: sizes in the units of the effect table, shift of
/// the boresight in mdeg.
Json DetectionLimitsJson(const std::vector<DetectionLimit>& effects);

/// Returns the effects that are undetectable at any size in one line. One line each follows for the
/// five effects that can shift the boresight most.
std::string DetectionLimitsSummary(const std::vector<DetectionLimit>& effects, bool with_boresight);

/// Returns a short description of the part of the gap that no effect explains; "" if there is none.
std::string UnexplainedWords(const GapDiagnosis& diagnosis);

/// Returns the verdict as one sentence without a full stop. For each effect it gives size, sigma,
/// the shift of the boresight and the key of flight.yaml that models it.
std::string VerdictSentence(const GapDiagnosis& diagnosis);

/// Returns a summary of the diagnosis for one screen: verdict, size of the gap, places, causes,
/// state before and after, and detection limits.
std::string GapSummary(const GapDiagnosis& diagnosis);

/// A plot of a diagnosis, for DrawSvg.
struct GapPlot {
  std::string file;
  std::string title;
  std::string x_label;
  std::vector<PlotPanel> panels;
};

/// Returns the plots for which the diagnosis has data: ranking of the causes, fingerprint, before
/// and after.
std::vector<GapPlot> GapPlots(const GapDiagnosis& diagnosis);

}  // namespace dn
