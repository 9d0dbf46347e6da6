#include <dn/report/plot.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace dn {
namespace {

using ::testing::HasSubstr;

bool GnuplotIsInstalled() { return std::system("gnuplot --version >/dev/null 2>&1") == 0; }

const std::vector<PlotPanel>& TwoPanels() {
  static const std::vector<PlotPanel> panels{
      {"east [m]", {{"it's", {{0.0, 1.0}, {1.0, -1.0}}}, {"empty", {}}}},
      {"north [m]", {{"points", {{0.0, 2.0}, {1.0, 3.0}}, false}}}};
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

TEST(Plot, TheSameInputGivesTheSameText) {
  if (!GnuplotIsInstalled()) GTEST_SKIP() << "gnuplot is not installed";
  EXPECT_EQ(DrawSvg("a", "t", TwoPanels()), DrawSvg("a", "t", TwoPanels()));
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

}  // namespace
}  // namespace dn
