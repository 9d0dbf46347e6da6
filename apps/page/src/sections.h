#pragma once

#include <dn/report/document.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::page_internal {

/// Returns a table without rows that has a column per angle of the boresight.
Table AngleTable(const std::string& title);

/// Returns a row of a name and cells.
std::vector<Cell> Row(std::string name, std::vector<Cell> cells);

/// Returns three cells of a list of three numbers.
std::vector<Cell> Three(const Facts& list, int decimals, double scale = 1.0);

/// Returns a map of correlations, which are drawn in per cent.
HeatMap Correlations(const std::string& title, const std::vector<std::string>& rows,
                     const std::vector<std::string>& columns, const Facts& matrix);

/// Returns a column of a table of numbers, minus the constant `minus`.
std::vector<double> Column(const TextTable& table, std::size_t column, double minus = 0.0);

/// Returns the curve with no more points than a screen can show.
Curve OnScreen(const Curve& curve);

/// Returns a table with a row for each contribution to a boresight, at most so many. PureModelRow
/// has the sigmas of the pure model in the same columns.
Table ContributionTable(const Facts& boresight, std::size_t most = SIZE_MAX);
std::vector<Cell> PureModelRow(const Facts& boresight);

/// Returns the section of the pairs: differences before and after per pair of strips, maps, and
/// remaining differences by scan angle, range, heading and time. `suffix` is that of the file
/// names.
Section PairSection(const ResultFolder& folder, const Facts& result, const std::string& suffix);

/// Returns a table of the USGS quality levels that height differences with this rms meet.
Table UsgsTable(double rms_m, const std::string& note);

/// Returns the height differences of the surfaces of the strips, before and after, by georef.json.
Section StripSurfacesSection(const ResultFolder& folder);

/// Shares of the pairs of two strips by height difference, before or after the step in `when`.
struct Separation {
  std::string strips;
  std::string when;
  Facts shares;
};

/// Returns a table of the separations that are present.
Section SeparationSection(const std::vector<Separation>& separations);

/// Returns the path of the flight, its strips, and standard deviations over time. The section has
/// no contents if the folder has none of these.
Section TrajectorySection(const ResultFolder& folder);

/// Returns the inertial biases with their bands.
Section BiasSection(const ResultFolder& folder);

/// Returns the value of an effect with its sigma, in the units of the table of effects.
std::string EffectSize(const Facts& effect);

/// Returns the decisive reasons, and how many more there are. ModelCheckSection has all findings.
std::vector<std::string> FirstReasons(const Facts& assessment);

/// Returns the groups, effects, clocks and findings of the model check.
Section ModelCheckSection(const Facts& result);

/// Returns the control points, the accuracy by withheld checks, and the shift of the datum.
Section ControlSection(const Facts& result);

/// Returns the boresights of several scanners, and the relative mountings of every two.
Section ScannerSection(const Facts& result);

/// Returns the corrections of the beams of scanners with several beams.
Section BeamSection(const Facts& result);

/// Returns the detection limits of `could_still_hide`: the sizes from which each effect is
/// detectable and identifiable, and the shift of the boresight.
Section UndetectableSection(const Facts& effects);

/// Returns the innovations and residuals per sensor and axis.
Section StatisticsSection(const Facts& innovations, const Facts& residuals);

/// Returns the counts, warnings, versions and settings.
std::vector<Section> RunSections(const ResultFolder& folder);

/// Adds the section if it has contents.
void Append(Section section, Document* document);

/// Meaning of a verdict for the reader.
struct Meaning {
  std::string answer;
  Tone tone;
  std::vector<std::string> next;
};

/// Adds the meaning of the verdict, if it is known.
void Explain(const std::map<std::string, Meaning>& meanings, const std::string& verdict,
             Headline* headline);

/// Starts a document with the flight, the command and the version.
Document Begin(const ResultFolder& folder, const std::string& name, const std::string& what);

/// Returns the correlations of the boresight with the biases.
Section BiasCorrelationSection(const Facts& correlations);

/// Returns the figures of an adjustment in two columns, without absent values.
Table AdjustmentTable(const Facts& adjustment);

// Pages of the commands.
Document CalibrationPage(const ResultFolder& folder);
/// Returns the page of a calibration with several flights.
Document FleetPage(const ResultFolder& folder);
Document SmoothPage(const ResultFolder& folder);
Document GapPage(const ResultFolder& folder);
Document StudyPage(const ResultFolder& folder);
Document MonteCarloPage(const ResultFolder& folder);
Document AllanPage(const ResultFolder& folder);
Document MatchPage(const ResultFolder& folder);
Document GeorefPage(const ResultFolder& folder);
Document BlindPage(const ResultFolder& folder);
Document SweepPage(const ResultFolder& folder);
/// Returns the page of a command without a verdict: simulate, check.
Document OtherPage(const ResultFolder& folder);
/// Returns the page of a command that refused its data: reason, steps that were tried, data.
Document RefusalPage(const ResultFolder& folder);

}  // namespace dn::page_internal
