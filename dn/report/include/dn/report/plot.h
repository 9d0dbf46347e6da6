#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// One curve or cloud of points.
struct PlotSeries {
  std::string label;
  std::vector<std::pair<double, double>> points;
  bool lines = true;
};

/// A plot with one or several panels stacked above a common abscissa.
struct PlotPanel {
  std::string y_label;
  std::vector<PlotSeries> series;
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

/// Process id of the gnuplot that draws at this moment, 0: none. May be called from a signal
/// handler.
int DrawingProcess() noexcept;

}  // namespace dn
