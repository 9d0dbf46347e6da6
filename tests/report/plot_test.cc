#include <dn/report/plot.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "testing/temp_folder.h"

namespace dn::report_test {

using ::testing::HasSubstr;

bool GnuplotIsInstalled() { return std::system("gnuplot --version >/dev/null 2>&1") == 0; }

const std::vector<PlotPanel>& TwoPanels() {
  static const std::vector<PlotPanel> panels{
      {"east [m]", {{"it's", {{0.0, 1.0}, {1.0, -1.0}}}, {"empty", {}}}},
      {"north [m]", {{"points", {{0.0, 2.0}, {1.0, 3.0}}, PlotStyle::kPoints}}}};
  return panels;
}

TEST(Plot, DrawsEveryLabel) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  const auto svg = DrawSvg("Innovations", "time [s]", TwoPanels());
  ASSERT_TRUE(svg.has_value());
  EXPECT_THAT(*svg, HasSubstr("<svg"));
  EXPECT_THAT(*svg, HasSubstr("</svg>"));
  for (const char* label : {"Innovations", "time [s]", "east [m]", "north [m]", "points"}) {
    EXPECT_THAT(*svg, HasSubstr(label));
  }
  EXPECT_THAT(*svg, ::testing::AnyOf(HasSubstr("it's"), HasSubstr("it&#39;s")));
}

TEST(PlotDeathTest, NothingIsDrawnAfterTheEndOfDrawing) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  const auto draw_after_the_end = [] {
    const bool before = DrawSvg("a", "t", TwoPanels()).has_value();
    EndDrawing();
    const bool after = DrawSvg("a", "t", TwoPanels()).has_value();
    std::_Exit(before && !after ? 0 : 1);
  };
  EXPECT_EXIT(draw_after_the_end(), ::testing::ExitedWithCode(0), "");
}

TEST(Plot, TheSameInputGivesTheSameText) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  EXPECT_EQ(DrawSvg("a", "t", TwoPanels()), DrawSvg("a", "t", TwoPanels()));
}

/// Returns the shapes of one kind in an SVG.
std::size_t Count(const std::string& svg, const std::string& shape) {
  std::size_t count = 0;
  for (std::size_t at = svg.find(shape); at != std::string::npos; at = svg.find(shape, at + 1)) {
    ++count;
  }
  return count;
}

TEST(Plot, DrawsBarsAndSpansOnNamedRows) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  const PlotPanel bars{
      "", {{"size", {{3.0, 0.0}, {-1.0, 1.0}}, PlotStyle::kBars}}, {"first row", "second row"}};
  const PlotPanel more{
      "",
      {{"size", {{3.0, 0.0}, {-1.0, 1.0}, {2.0, 1.0}}, PlotStyle::kBars},
       {"range", {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {2.0, 1.0}}, PlotStyle::kSpans}},
      {"first row", "second row"}};
  const auto svg = DrawSvg("Rows", "x", {bars});
  const auto longer = DrawSvg("Rows", "x", {more});
  ASSERT_TRUE(svg && longer);
  EXPECT_THAT(*svg, HasSubstr("first row"));
  EXPECT_THAT(*svg, HasSubstr("second row"));
  EXPECT_GT(Count(*longer, "<polygon"), Count(*svg, "<polygon"));
  EXPECT_GT(Count(*longer, "<path"), Count(*svg, "<path"));
}

TEST(Plot, ManyRowsMakeAHighPlot) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  PlotPanel panel{"", {{"size", {}, PlotStyle::kBars}}, {}};
  for (int i = 0; i < 40; ++i) {
    panel.series[0].points.emplace_back(1.0, i);
    panel.rows.push_back("row " + std::to_string(i));
  }
  const auto svg = DrawSvg("Rows", "x", {panel});
  ASSERT_TRUE(svg.has_value());
  EXPECT_THAT(*svg, HasSubstr("row 39"));
  EXPECT_THAT(*svg, HasSubstr("height=\"850\""));
}

TEST(Plot, NothingWithoutPanels) { EXPECT_FALSE(DrawSvg("a", "t", {}).has_value()); }

TEST(Plot, NothingWithoutGnuplot) {
  const char* path = std::getenv("PATH");
  const std::string before = path == nullptr ? "" : path;
  setenv("PATH", "/nonexistent", 1);
  const auto svg = DrawSvg("a", "t", TwoPanels());
  setenv("PATH", before.c_str(), 1);
  EXPECT_FALSE(svg.has_value());
}

/// Sets a variable of the environment and restores it at the end of the scope.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Variable() {
    if (before_) {
      setenv(name_, before_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

/// Puts a program named gnuplot first on the path during its lifetime.
class OtherGnuplot {
 public:
  explicit OtherGnuplot(const std::string& commands)
      : path_("PATH", folder_.path().string() + ":" + std::getenv("PATH")) {
    folder_.Write("gnuplot", "#!/bin/sh\n" + commands);
    std::filesystem::permissions(folder_.path() / "gnuplot", std::filesystem::perms::owner_all);
  }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  testing::TempFolder folder_;
  Variable path_;
};

TEST(Plot, NoTextReachesAnInterpreter) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  const testing::TempFolder folder;
  const std::string touch = "touch '" + (folder.path() / "touched").string() + "'";
  const std::string twice = "touch \"" + (folder.path() / "touched").string() + "\"";
  for (const std::string& text :
       {"a\n!" + touch + "\n", "a\r\nsystem('" + twice + "')", "`" + touch + "`",
        "'; system('" + twice + "') #", "a\nEOD\n!" + touch, "\\\n!" + touch}) {
    std::vector<PlotPanel> panels = TwoPanels();
    panels[0].y_label = panels[0].series[0].label = text;
    EXPECT_TRUE(DrawSvg(text, text, panels).has_value()) << text;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "touched")) << text;
  }
}

TEST(Plot, TextsAreDrawnUnchanged) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  const auto svg = DrawSvg("strip_1 <b>^{2}", "t", TwoPanels());
  ASSERT_TRUE(svg.has_value());
  EXPECT_THAT(*svg, HasSubstr("strip_1 &lt;b>^{2}"));
}

TEST(Plot, NeedsNoTemporaryFolderAndReadsNoStartUpFile) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  const testing::TempFolder folder;
  folder.Write(".gnuplot", "system('touch " + (folder.path() / "touched").string() + "')\n");
  const Variable home("HOME", folder.path().string());
  const Variable temporary("TMPDIR",
                           "/nonexistent'; touch " + folder.path().string() + "/touched;'");
  EXPECT_TRUE(DrawSvg("a", "t", TwoPanels()).has_value());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "touched"));
}

TEST(Plot, TheEnvironmentStaysHere) {
  const OtherGnuplot other("env >\"${0%/*}/environment\"");
  const Variable secret("GNUPLOT_LIB", "/tmp/x");
  EXPECT_FALSE(DrawSvg("a", "t", TwoPanels()).has_value());
  std::ifstream in(other.folder() / "environment");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_THAT(text, HasSubstr("PATH="));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("GNUPLOT_LIB")));
}

TEST(Plot, AnInterruptionEndsAGnuplotThatHangs) {
  const OtherGnuplot other("exec sleep 60");
  const auto start = std::chrono::steady_clock::now();
  const auto after_a_while = [&] {
    return std::chrono::steady_clock::now() - start > std::chrono::milliseconds(50);
  };
  EXPECT_FALSE(DrawSvg("a", "t", TwoPanels(), after_a_while).has_value());
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(Plot, NothingWhereGnuplotFails) {
  const OtherGnuplot other("echo '<svg></svg>'; exit 1");
  EXPECT_FALSE(DrawSvg("a", "t", TwoPanels()).has_value());
}

}  // namespace dn::report_test
