#include <dn/names.h>
#include <dn/report/plot.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "gnuplot_process.h"

namespace dn {
namespace {

constexpr int kPanelHeight = 260;
constexpr int kRowHeight = 18;
constexpr int kFrameHeight = 90;  // space for title, label and numbers of the abscissa
constexpr int kWidth = 900;

/// Returns a gnuplot string in which every special character is an octal code.
std::string QuoteForGnuplot(const std::string& text) {
  constexpr std::string_view kPlain = " .,:;+-=()[]/";
  std::string quoted = "\"";
  for (const char c : WithoutControls(text)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain =
        byte >= 0x80 || std::isalnum(byte) != 0 || kPlain.find(c) != std::string_view::npos;
    quoted += plain ? std::string(1, c) : fmt::format("\\{:03o}", byte);
  }
  return quoted + "\"";
}

/// Returns the part of a plot command that draws the data block of a series.
std::string PlotClause(const std::string& data, PlotStyle style) {
  switch (style) {
    case PlotStyle::kLines:
      return data + " using 1:2 with lines";
    case PlotStyle::kPoints:
      return data + " using 1:2 with points pointtype 7 pointsize 0.3";
    case PlotStyle::kBars:
      return data +
             " using (0.5*$1):2:(0):1:($2-0.16):($2+0.16) with boxxyerror fillstyle solid 0.6";
    case PlotStyle::kSpans:
      return data + " using 1:2 with lines linewidth 5";
  }
  return {};
}

std::string DataBlock(int number, const PlotSeries& series) {
  std::string text = fmt::format("$d{} << EOD\n", number);
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    if (series.style == PlotStyle::kSpans && i > 0 && i % 2 == 0) text += "\n";
    text += fmt::format("{:.10g} {:.6g}\n", series.points[i].first, series.points[i].second);
  }
  return text + "EOD\n";
}

/// Returns the commands for the ordinate: numbers, or the names of the rows.
std::string Ordinate(const std::vector<std::string>& rows) {
  if (rows.empty()) return "set ytics autofreq\nset yrange [*:*]\n";
  std::string tics;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    tics += fmt::format("{}{} {}", i == 0 ? "" : ", ", QuoteForGnuplot(rows[i]), i);
  }
  return fmt::format("set ytics ({})\nset yrange [{:.1f}:-0.5]\n", tics,
                     static_cast<double>(rows.size()) - 0.5);
}

/// Returns the height of each panel; all panels of a plot have the height of the highest one.
int PanelHeight(const std::vector<PlotPanel>& panels) {
  int height = kPanelHeight;
  for (const PlotPanel& panel : panels) {
    height = std::max(height, kRowHeight * static_cast<int>(panel.rows.size()) + kFrameHeight);
  }
  return height;
}

std::string Script(const std::string& title, const std::string& x_label,
                   const std::vector<PlotPanel>& panels) {
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg noenhanced size {},{} background rgb 'white' font 'sans,12'\n"
      "set multiplot layout {},1 title {}\nset grid\nset key outside right\n",
      kWidth, PanelHeight(panels) * static_cast<int>(panels.size()) + 40, panels.size(),
      QuoteForGnuplot(title));
  int data = 0;
  for (const PlotPanel& panel : panels) {
    std::string plot;
    for (const PlotSeries& series : panel.series) {
      if (series.points.empty()) continue;
      script += DataBlock(data, series);
      plot += fmt::format("{}{} title {}", plot.empty() ? "plot " : ", ",
                          PlotClause(fmt::format("$d{}", data), series.style),
                          QuoteForGnuplot(series.label));
      ++data;
    }
    if (plot.empty()) continue;
    script += fmt::format("set ylabel {}\n", QuoteForGnuplot(panel.y_label)) + Ordinate(panel.rows);
    if (&panel == &panels.back())
      script += fmt::format("set xlabel {}\n", QuoteForGnuplot(x_label));
    script += plot + "\n";
  }
  return script + "unset multiplot\n";
}

}  // namespace

std::optional<std::string> DrawSvg(const std::string& title, const std::string& x_label,
                                   const std::vector<PlotPanel>& panels,
                                   const std::function<bool()>& interrupted) {
  if (panels.empty()) return std::nullopt;
  std::optional<std::string> svg =
      report_internal::RunGnuplot(Script(title, x_label, panels), interrupted);
  if (!svg || svg->find("</svg>") == std::string::npos) return std::nullopt;
  return svg;
}

void EndDrawing() noexcept { report_internal::ForbidGnuplot(); }

}  // namespace dn
