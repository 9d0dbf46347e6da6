#pragma once

#include <dn/report/json.h>
#include <dn/report/plot.h>
#include <dn/study/study.h>

#include <string>
#include <vector>

namespace dn {

/// Returns study.json (schema dn.study/1).
Json StudyJson(const StudyResult& study);

/// Returns correlations.txt. A row has the time, then the correlations of roll, pitch and yaw with
/// the accelerometer biases x, y, z each. Those with the gyro biases follow in the same order.
std::string FormatCorrelations(const std::vector<BiasCorrelationAt>& correlations);

/// Returns a summary of a study for one screen.
std::string StudySummary(const StudyResult& study);

/// Returns why a direction is weak: what the strips have in common, else what limits it.
std::string CauseWords(const StudyResult& study, const StudyDirection& direction);

/// Returns what would help, in the words of a flight plan, and whether it was tried.
std::string RemedyWords(const StudyResult& study, const StudyDirection& direction);

/// Returns why the design is not observable, one line per reason; empty if it is observable.
std::vector<std::string> UnobservableWords(const StudyResult& study);

/// A plot for DrawSvg.
struct StudyPlot {
  std::string file;
  std::string title;
  std::string x_label;
  std::vector<PlotPanel> panels;
};

/// Returns plots of the sigmas of the boresight, its correlation with the biases over time, and the
/// sigmas of the trajectory over time.
std::vector<StudyPlot> StudyPlots(const StudyResult& study);

}  // namespace dn
