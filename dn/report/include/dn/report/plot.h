#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Style in which the points of a series are drawn.
enum class PlotStyle {
  kLines,   ///< joined by lines
  kPoints,  ///< a cloud of points
  kBars,    ///< a horizontal bar from abscissa 0 for each point
  kSpans,   ///< a thick line for each two consecutive points
};

/// A curve, a cloud of points, or a set of bars.
struct PlotSeries {
  std::string label;
  std::vector<std::pair<double, double>> points;
  PlotStyle style = PlotStyle::kLines;
};

/// One of the panels that a plot stacks above a common abscissa.
struct PlotPanel {
  std::string y_label;
  std::vector<PlotSeries> series;
  /// Names of the ordinates 0, 1, ..., from the top down; numbers if empty. The panel is as high as
  /// they require.
  std::vector<std::string> rows = {};
};

/// Returns the SVG text of a plot that gnuplot draws. Returns nullopt if gnuplot is not installed,
/// fails or takes longer than 20 s, or if `interrupted`, which is polled, returns true. The result
/// files have the same numbers.
///
/// gnuplot runs without a shell, without its start-up files, and with PATH as the only variable of
/// the user's environment. Control characters in texts are drawn as spaces.
std::optional<std::string> DrawSvg(const std::string& title, const std::string& x_label,
                                   const std::vector<PlotPanel>& panels,
                                   const std::function<bool()>& interrupted = {});

/// Kills a running gnuplot, and prevents all threads from starting another one. It is for the end
/// of the program, and may be called from a signal handler.
void EndDrawing() noexcept;

}  // namespace dn
