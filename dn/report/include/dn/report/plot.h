#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// How the points of a series are drawn.
enum class PlotStyle {
  kLines,   ///< joined
  kPoints,  ///< a cloud
  kBars,    ///< each a horizontal bar from abscissa 0
  kSpans,   ///< each two, one after the other, joined by a thick line
};

/// One curve, cloud of points, or set of bars.
struct PlotSeries {
  std::string label;
  std::vector<std::pair<double, double>> points;
  PlotStyle style = PlotStyle::kLines;
};

/// A plot with one or several panels stacked above a common abscissa.
struct PlotPanel {
  std::string y_label;
  std::vector<PlotSeries> series;
  /// Names of the ordinates 0, 1, ..., from the top down; empty: numbers. The panel is as high as
  /// they need.
  std::vector<std::string> rows = {};
};

/// SVG text of the plot, drawn by gnuplot. Nothing where gnuplot is not installed, fails, takes
/// longer than 20 s or `interrupted`, polled meanwhile, says so: the numbers are in the result
/// files anyway.
///
/// gnuplot runs without a shell, without its start-up files and without the user's environment but
/// for PATH; control characters of a text are drawn as blanks.
std::optional<std::string> DrawSvg(const std::string& title, const std::string& x_label,
                                   const std::vector<PlotPanel>& panels,
                                   const std::function<bool()>& interrupted = {});

/// Ends the gnuplot that draws at this moment, and none is started any more, on no thread: for the
/// end of the program. May be called from a signal handler.
void EndDrawing() noexcept;

}  // namespace dn
