#pragma once

#include <dn/report/document.h>

#include <map>
#include <string>
#include <vector>

#include "result_folder.h"

namespace dn::internal {

// The axes of three numbers.
inline const std::vector<std::string> kBoresightAngles{"roll", "pitch", "yaw"};
inline const std::vector<std::string> kEnu{"east", "north", "up"};
inline const std::vector<std::string> kXyz{"x", "y", "z"};

/// A row: a name and cells.
std::vector<Cell> Row(std::string name, std::vector<Cell> cells);

/// The three cells of a list of three.
std::vector<Cell> Three(const Facts& list, int decimals, double scale = 1.0);

/// A matrix of correlations, in per cent when drawn.
HeatMap Correlations(const std::string& title, const std::vector<std::string>& rows,
                     const std::vector<std::string>& columns, const Facts& matrix);

/// A column of a table of numbers; `minus` is taken off.
std::vector<double> Column(const TextTable& table, std::size_t column, double minus = 0.0);

/// The points of a curve that a screen shows.
Curve OnScreen(const Curve& curve);

/// Before and after per pair of strips, where the pairs lie, and what is left of them by scan angle,
/// range, heading and time. `suffix` as in the names of the files.
Section PairSection(const ResultFolder& folder, const Facts& result, const std::string& suffix);

/// Shares of the pairs of two strips by difference of height; `when`: before or after what.
struct Separation {
  std::string strips;
  std::string when;
  Facts shares;
};

/// Those that are there, in a table.
Section SeparationSection(const std::vector<Separation>& separations);

/// The path of the flight, its strips, and standard deviations over time; without contents where
/// the folder has none of them.
Section TrajectorySection(const ResultFolder& folder);

/// Inertial biases with their bands.
Section BiasSection(const ResultFolder& folder);

/// The value of an effect with its sigma, in the units of the table of effects.
std::string SizeOf(const Facts& effect);

/// The reasons that decide, and how many more there are: ModelCheckSection has all findings.
std::vector<std::string> FirstReasons(const Facts& assessment);

/// Groups, effects, clocks, findings.
Section ModelCheckSection(const Facts& result);

/// `could_still_hide` of a result: from which size on each effect is seen and named, and the damage.
Section CouldHideSection(const Facts& effects);

/// Innovations and residuals per sensor and axis.
Section StatisticsSection(const Facts& innovations, const Facts& residuals);

/// Counts, warnings, versions and settings.
std::vector<Section> RunSections(const ResultFolder& folder);

/// Adds the section where it has contents.
void Append(Section section, Document* document);

/// What a verdict means for who reads it.
struct Meaning {
  const char* answer;
  Tone tone;
  std::vector<std::string> next;
};

/// Adds what the verdict means, where that is known.
void Explain(const std::map<std::string, Meaning>& meanings, const std::string& verdict,
             Headline* headline);

/// Flight and command, versions.
Document Begin(const ResultFolder& folder, const std::string& name, const std::string& what);

/// The correlations of the boresight with the biases.
Section BiasCorrelationSection(const Facts& correlations);

/// Figures of an adjustment in two columns, what is absent left out.
Table AdjustmentTable(const Facts& adjustment);

// One page each.
Document CalibrationPage(const ResultFolder& folder);
Document SmoothPage(const ResultFolder& folder);
Document GapPage(const ResultFolder& folder);
Document StudyPage(const ResultFolder& folder);
Document MonteCarloPage(const ResultFolder& folder);
Document AllanPage(const ResultFolder& folder);
Document MatchPage(const ResultFolder& folder);
Document GeorefPage(const ResultFolder& folder);
Document BlindPage(const ResultFolder& folder);
Document SweepPage(const ResultFolder& folder);
/// Of commands without a verdict: simulate, check.
Document OtherPage(const ResultFolder& folder);

}  // namespace dn::internal
