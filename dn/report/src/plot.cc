#include <dn/report/plot.h>
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

namespace dn {
namespace {

constexpr int kPanelHeight = 260;
constexpr int kWidth = 900;

std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::string Script(const std::string& title, const std::string& x_label,
                   const std::vector<PlotPanel>& panels, const std::string& svg) {
  std::string script = fmt::format(
      "set terminal svg size {},{} background rgb 'white' font 'sans,12'\nset output {}\n"
      "set multiplot layout {},1 title {}\nset grid\nset key outside right\n",
      kWidth, kPanelHeight * static_cast<int>(panels.size()) + 40, Quoted(svg), panels.size(),
      Quoted(title));
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

/// A private directory that disappears with the object; empty path when none can be made.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "dn-plot-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~ScratchDirectory() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

std::optional<std::string> DrawSvg(const std::string& title, const std::string& x_label,
                                   const std::vector<PlotPanel>& panels) {
  const ScratchDirectory scratch;
  if (scratch.path().empty() || panels.empty()) return std::nullopt;
  const std::filesystem::path svg = scratch.path() / "plot.svg";
  const std::filesystem::path script = scratch.path() / "plot.gp";
  std::ofstream(script) << Script(title, x_label, panels, svg.string());
  const std::string command = "gnuplot '" + script.string() + "' >/dev/null 2>&1 </dev/null";
  if (std::system(command.c_str()) != 0) return std::nullopt;
  std::ifstream in(svg, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (text.empty()) return std::nullopt;
  return text;
}

}  // namespace dn
