#include <dn/names.h>
#include <dn/report/plot.h>
#include <fmt/format.h>

#include <cctype>
#include <string_view>

#include "gnuplot_process.h"

namespace dn {
namespace {

constexpr int kPanelHeight = 260;
constexpr int kWidth = 900;

/// A gnuplot string in which every character that might end it or mean something is an octal code.
std::string Quoted(const std::string& text) {
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

std::string Script(const std::string& title, const std::string& x_label,
                   const std::vector<PlotPanel>& panels) {
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg noenhanced size {},{} background rgb 'white' font 'sans,12'\n"
      "set multiplot layout {},1 title {}\nset grid\nset key outside right\n",
      kWidth, kPanelHeight * static_cast<int>(panels.size()) + 40, panels.size(), Quoted(title));
  int data = 0;
  for (const PlotPanel& panel : panels) {
    std::string plot;
    for (const PlotSeries& series : panel.series) {
      if (series.points.empty()) continue;
      script += fmt::format("$d{} << EOD\n", data);
      for (const auto& [x, y] : series.points) script += fmt::format("{:.10g} {:.6g}\n", x, y);
      script += "EOD\n";
      plot += fmt::format("{}$d{} using 1:2 with {} title {}", plot.empty() ? "plot " : ", ", data,
                          series.lines ? "lines" : "points pointtype 7 pointsize 0.3",
                          Quoted(series.label));
      ++data;
    }
    if (plot.empty()) continue;
    script += fmt::format("set ylabel {}\n", Quoted(panel.y_label));
    if (&panel == &panels.back()) script += fmt::format("set xlabel {}\n", Quoted(x_label));
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
      internal::RunGnuplot(Script(title, x_label, panels), interrupted);
  if (!svg || svg->find("</svg>") == std::string::npos) return std::nullopt;
  return svg;
}

int DrawingProcess() noexcept { return internal::GnuplotProcess(); }

}  // namespace dn
