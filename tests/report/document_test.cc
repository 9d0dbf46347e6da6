#include <dn/report/document.h>
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>

namespace dn::report_test {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kMaxPageBytes = 3000000;
const double kNone = std::numeric_limits<double>::quiet_NaN();

std::size_t CountOccurrences(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

/// Returns the data from which the page draws its charts.
Json ChartData(const std::string& html) {
  const std::string begin = "id=\"dn-data\">";
  const std::size_t at = html.find(begin) + begin.size();
  return Json::parse(html.substr(at, html.find("</script>", at) - at));
}

Document OneSection(Content content) {
  Document document;
  document.title = "flight";
  document.sections = {{"section", {std::move(content)}}};
  return document;
}

TEST(Number, ShowsItsDigits) {
  EXPECT_EQ(ToText(Number{0.123456, 3}), "0.123");
  EXPECT_EQ(ToText(Number{0.123456, 2, Number::Style::kDecimals, 1e3}), "123.46");
  EXPECT_EQ(ToText(Number{-0.0004, 3, Number::Style::kDecimals}), "0.000");
  EXPECT_EQ(ToText(Number{kNone}), "–");
}

TEST(Html, ANumberCarriesItsValueAndSource) {
  const double value = 0.20028536318161688;
  const std::string html = ToHtml(OneSection(Table{
      "", {"sigma"}, {{Cell{Number{value, 4, Number::Style::kDecimals, 1.0, "r.json#/a"}}}}}));
  EXPECT_THAT(html, HasSubstr("data-value=\"0.20028536318161688\""));
  EXPECT_THAT(html, HasSubstr("data-source=\"r.json#/a\""));
  EXPECT_THAT(html, HasSubstr(">0.2003</td>"));
}

TEST(Html, TextsAreEscaped) {
  const std::string evil = "</script><script>alert(1)</script><img src=x onerror='a' \"b\">&amp;";
  Document document = OneSection(Table{evil, {evil}, {{Cell{evil}}}, evil});
  document.title = document.subtitle = evil;
  document.headlines = {{evil, evil, Tone::kBad, {evil}, {}, {evil}}};
  document.sections[0].title = evil;
  for (Content content :
       std::vector<Content>{Paragraph{evil}, Listing{evil, evil},
                            Chart{SeriesChart{evil, evil, evil, {{evil, {1}, {2}}}}},
                            Chart{BarChart{evil, evil, {{evil, evil, 1, 0, 2}}}},
                            Chart{HeatMap{evil, {evil}, {evil}, {{0.5}}}}}) {
    document.sections[0].contents.push_back(std::move(content));
  }
  const std::string html = ToHtml(document);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_EQ(CountOccurrences("<script", html), CountOccurrences("</script", html));
  EXPECT_EQ(ChartData(html)["charts"][0]["title"], evil);
}

TEST(Html, ReplacesBytesThatAreNotUtf8) {
  const std::string html =
      ToHtml(OneSection(Chart{BarChart{"\xff\xfe", "x", {{"\xff", "", 1, 0, 2}}}}));
  EXPECT_TRUE(ChartData(html)["charts"][0]["bars"].is_array());
}

TEST(Html, LoadsNothing) {
  const std::string html = ToHtml(OneSection(Chart{SeriesChart{"t", "x", "y", {{"a", {1}, {2}}}}}));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  const std::regex loads(R"((src|href)\s*=\s*"(?!#|data:,")|@import|url\(\s*["']?http)");
  const std::string own = html.substr(0, html.find("<script>"));
  EXPECT_FALSE(std::regex_search(own, loads));
}

TEST(Html, OnlyTheLibrariesThatItNeeds) {
  const std::string bare = ToHtml(OneSection(Paragraph{"text"}));
  EXPECT_LT(bare.size(), 20000u);
  EXPECT_THAT(bare, Not(HasSubstr("<script")));
  const std::string series = ToHtml(OneSection(Chart{SeriesChart{"t", "x", "y", {}}}));
  EXPECT_THAT(series, HasSubstr("uplot 1."));
  EXPECT_THAT(series, Not(HasSubstr("d3 7.")));
  EXPECT_LT(series.size(), 100000u);
}

TEST(Html, ChartsKeepMissingNumbers) {
  const Json data = ChartData(ToHtml(OneSection(
      Chart{SeriesChart{"t", "x", "y", {{"a", {0, 1}, {1.23456789, kNone}, {1, 1}, {2, 2}}}}})));
  const Json& curve = data["charts"][0]["curves"][0];
  EXPECT_EQ(curve["y"], Json({1.234568, nullptr}));
  EXPECT_EQ(curve["high"], Json({2.0, 2.0}));
}

// One hour at 200 nodes per second, with as many curves as a calibration has.
TEST(ThinCurve, AnHourOfFlightStaysSmall) {
  constexpr std::size_t kEpochs = 720000;
  Curve curve{"x", {}, {}, {}, {}};
  for (std::size_t k = 0; k < kEpochs; ++k) {
    const double t_s = 0.005 * static_cast<double>(k);
    const double y = std::sin(12345.6789 * t_s);
    curve.x.push_back(t_s);
    curve.y.push_back(y);
    curve.low.push_back(y - 1.0 / 3.0);
    curve.high.push_back(y + 1.0 / 3.0);
  }
  const Curve thin = ThinCurve(curve, 1200);
  SeriesChart chart{"biases", "time [s]", "y", {thin, thin, thin}};
  Document document = OneSection(Chart{chart});
  for (int k = 0; k < 4; ++k) document.sections[0].contents.emplace_back(Chart{chart});
  EXPECT_LT(ToHtml(document).size(), kMaxPageBytes);
}

TEST(ThinCurve, KeepsPeaksAndEnds) {
  Curve curve{"x", {}, {}};
  for (int k = 0; k < 10000; ++k) {
    curve.x.push_back(k);
    curve.y.push_back(k == 4321 ? 50.0 : k == 8765 ? -70.0 : 0.0);
  }
  const Curve thin = ThinCurve(curve, 200);
  EXPECT_LE(thin.x.size(), 200u);
  EXPECT_EQ(thin.x.size(), thin.y.size());
  EXPECT_EQ(*std::max_element(thin.y.begin(), thin.y.end()), 50.0);
  EXPECT_EQ(*std::min_element(thin.y.begin(), thin.y.end()), -70.0);
  EXPECT_TRUE(std::is_sorted(thin.x.begin(), thin.x.end()));
  EXPECT_EQ(ThinCurve(thin, 200).x, thin.x);
}

TEST(Text, HeadlinesAndTables) {
  Document document = OneSection(
      Table{"angles", {"", "deg"}, {{Cell{std::string("roll")}, Cell{Number{0.25}}}}, "a note"});
  document.headlines = {{"calibrated", "You may rely on it.", Tone::kGood, {"a reason"}}};
  EXPECT_EQ(ToText(document),
            "flight\ncalibrated: You may rely on it.\n  a reason\nangles\n         deg\n  roll  "
            "0.25\n  a note\n");
}

}  // namespace dn::report_test
