#pragma once

#include <dn/report/json.h>
#include <dn/report/plot.h>
#include <dn/study/study.h>

#include <string>
#include <vector>

namespace dn {

/// study.json (schema dn.study/1).
Json StudyJson(const StudyResult& study);

/// correlations.txt: t, then of roll, pitch and yaw the correlations with the accelerometer biases
/// x, y, z, and of each with the gyro biases.
std::string FormatCorrelations(const std::vector<BiasCorrelationAt>& correlations);

/// A study on one screen.
std::string StudySummary(const StudyResult& study);

/// Why a direction is weak: what the strips have in common, else what limits it.
std::string CauseWords(const StudyResult& study, const StudyDirection& direction);

/// What would help, in the words of a flight plan, and whether it was tried.
std::string RemedyWords(const StudyResult& study, const StudyDirection& direction);

/// Why the design is not observable, one line each; none where it is.
std::vector<std::string> UnobservableWords(const StudyResult& study);

/// A plot for DrawSvg.
struct StudyPlot {
  std::string file;
  std::string title;
  std::string x_label;
  std::vector<PlotPanel> panels;
};

/// Sigmas of the boresight, its correlation with the biases over time,
/// the sigmas of the trajectory over time.
std::vector<StudyPlot> StudyPlots(const StudyResult& study);

}  // namespace dn
