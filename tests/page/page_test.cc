#include <dn/error.h>
#include <dn/page/page.h>
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/temp_folder.h"

namespace dn::page_test {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::TempFolder;

Json Report() {
  return {{"schema", "dn.report/1"}, {"command", "calibrate"}, {"versions", {{"dn", "1.2.3"}}}};
}

Json Result(const std::string& method, double roll_deg, double sigma_deg) {
  const double variance = sigma_deg * sigma_deg;
  return {{"schema", "dn.result/1"},
          {"flight", "lar3"},
          {"method", method},
          {"boresight",
           {{"angles_deg", {roll_deg, 0.03, 0.35}},
            {"sigma_deg", {sigma_deg, sigma_deg, sigma_deg}},
            {"covariance_deg2", {{variance, 0, 0}, {0, variance, 0}, {0, 0, variance}}}}},
          {"assessment", {{"verdict", "calibrated"}, {"reasons", Json::array()}}}};
}

/// A folder with a result of one file.
class Folder : public TempFolder {
 public:
  Folder(const std::string& name, const Json& content, const Json& report = Report()) {
    Write("report.json", report.dump());
    Write(name, content.dump());
  }
};

const Table& DifferenceRows(const Document& document) {
  return std::get<Table>(document.sections.at(0).contents.at(0));
}

std::string TextAt(const Table& table, std::size_t row, std::size_t column) {
  return std::get<std::string>(table.rows.at(row).at(column).content);
}

double NumberAt(const Table& table, std::size_t row, std::size_t column) {
  return std::get<Number>(table.rows.at(row).at(column).content).value;
}

TEST(Page, ShowsTheAnglesOfSeveralFlights) {
  Json result = Result("dn", 0.2, 0.001);
  result["flights"] = Json::array();
  for (const double roll_deg : {0.2, 0.203, 0.199}) {
    result["flights"].push_back({{"flight", "monday"},
                                 {"angles_deg", {roll_deg, 0.03, 0.35}},
                                 {"sigma_deg", {0.002, 0.003, 0.004}},
                                 {"change_deg", {roll_deg - 0.2, 0, 0}},
                                 {"change_sigma_deg", {0.002, 0.003, 0.004}}});
  }
  result["excluded"] = {{{"flight", "friday"}, {"reason", "absorbed"}}};
  result["stability"] = {{"likeliest_change", {{"kind", "from_flight_on"}, {"flight", "monday"}}}};
  const Document page = MakePage(Folder("result.json", result).path());
  EXPECT_EQ(page.headlines.front().word, "calibrated");
  const Chart& roll = std::get<Chart>(page.sections.front().contents.front());
  const std::vector<Curve>& curves = std::get<SeriesChart>(roll).curves;
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_THAT(curves[0].x, ::testing::ElementsAre(1.0, 2.0, 3.0));
  EXPECT_DOUBLE_EQ(curves[0].high[1], 0.207);
  EXPECT_DOUBLE_EQ(curves[1].low[0], 0.198);  // of all flights
  EXPECT_THAT(ToText(page), HasSubstr("friday"));
}

TEST(Page, SaysOfEveryVerdictWhetherToRelyOnIt) {
  const std::pair<const char*, Tone> verdicts[] = {{"calibrated", Tone::kGood},
                                                   {"absorbed", Tone::kDoubtful},
                                                   {"not_observable", Tone::kBad},
                                                   {"contradicted", Tone::kBad}};
  for (const auto& [verdict, tone] : verdicts) {
    Json result = Result("dn", 0.2, 0.001);
    result["assessment"] = {{"verdict", verdict}, {"reasons", {"because"}}};
    const Folder folder("result.json", result);
    const Document page = MakePage(folder.path());
    ASSERT_EQ(page.headlines.size(), 1u);
    EXPECT_EQ(page.headlines[0].word, verdict);
    EXPECT_EQ(page.headlines[0].tone, tone) << verdict;
    EXPECT_EQ(page.headlines[0].reasons, std::vector<std::string>{"because"});
    EXPECT_FALSE(page.headlines[0].answer.empty());
    EXPECT_FALSE(page.headlines[0].next.empty());
  }
}

// Joined shards of a series must give the same bytes as one run.
TEST(Page, LeavesOutWhatTwoRunsOfOneWorkDifferIn) {
  Json other = Report();
  other["command"] = "merge";
  other["arguments"] = {"merge", "a", "b"};
  other["threads"] = 7;
  other["timings_s"] = {{"total", 12.5}};
  const Folder one("monte_carlo.json", {{"flights", 3}, {"consistent", true}});
  const Folder two("monte_carlo.json", {{"flights", 3}, {"consistent", true}}, other);
  EXPECT_EQ(ToHtml(MakePage(one.path())), ToHtml(MakePage(two.path())));
}

TEST(Page, WhatIsAbsentIsADash) {
  for (const char* name : {"result.json", "smooth.json", "gap.json", "study.json",
                           "monte_carlo.json", "allan.json", "other.json"}) {
    const Folder folder(name, {{"boresight", {{"angles_deg", {nullptr, "x"}}}}});
    EXPECT_THAT(ToHtml(MakePage(folder.path())), HasSubstr("1.2.3")) << name;
  }
}

TEST(Page, ACalibrationPrintsACertificate) {
  Json report = Report();
  report["inputs"] = {{{"file", "IMU.txt"}, {"bytes", 10}, {"sha256", std::string(64, 'a')}}};
  Json result = Result("dn", 0.2, 0.001);
  result["assessment"] = {{"verdict", "absorbed"}, {"reasons", {"a poor trajectory"}}};
  const Folder folder("result.json", result, report);
  folder.Write("config.resolved.yaml",
               "imu: {grade: airins}\ngnss: {lever_arm_m: [0.25, -0.5, -1.75]}\n");
  const Document page = MakePage(folder.path());
  ASSERT_EQ(page.certificate.size(), 2u);
  const auto& verdict = page.certificate[0].contents;
  EXPECT_THAT(std::get<Paragraph>(verdict[0]).text, HasSubstr("absorbed"));
  EXPECT_EQ(std::get<Paragraph>(verdict[1]).text, "a poor trajectory");
  const Table& angles = std::get<Table>(verdict[2]);
  EXPECT_EQ(NumberAt(angles, 0, 1), 0.2);
  EXPECT_EQ(NumberAt(angles, 1, 3), 0.001);
  const std::string html = ToHtml(page);
  EXPECT_THAT(html, HasSubstr("class=\"certified\""));
  for (const char* text : {"airins", "0.25, -0.5, -1.75", "IMU.txt"}) {
    EXPECT_THAT(html.substr(html.find("class=\"certificate\"")), HasSubstr(text));
  }
  EXPECT_THAT(html, HasSubstr(std::string(64, 'a')));
  EXPECT_THAT(ToHtml(MakePage(Folder("smooth.json", {{"flight", "x"}}).path())),
              Not(HasSubstr("class=\"certificate\"")));
}

TEST(Page, AFlightWithAHostileNameStaysAName) {
  Json result = Result("dn", 0.2, 0.001);
  result["flight"] = "</title><script>alert(1)</script>";
  result["estimates"] = {
      {"</td><script>alert(2)</script>", {{"value", {1.0}}, {"sigma", {0.1}}, {"unit", "<b>"}}}};
  const Folder folder("result.json", result);
  EXPECT_THAT(ToHtml(MakePage(folder.path())), Not(HasSubstr("<script>alert")));
}

TEST(Page, DamagedFilesAreNamed) {
  const Folder folder("result.json", Result("dn", 0.2, 0.001));
  folder.Write("result.json", "{");
  EXPECT_THROW((void)MakePage(folder.path()), InvalidInput);
  const TempFolder empty;
  EXPECT_THROW((void)MakePage(empty.path()), InvalidInput);
}

TEST(Comparison, IndependentResultsHaveTheSumOfTheirCovariances) {
  const Folder a("result.json", Result("dn", 0.200, 0.003));
  const Folder b("result.json", Result("dn", 0.206, 0.004));
  const Folder c("result.json", Result("dn", 0.300, 0.004));
  const Document page = MakePage(std::vector{a.path(), b.path(), c.path()});
  EXPECT_EQ(page.headlines.size(), 3u);
  const Table& differences = DifferenceRows(page);
  ASSERT_EQ(differences.rows.size(), 3u);
  constexpr double kTurnMdeg = 0.01;  // rotations do not quite commute
  EXPECT_NEAR(NumberAt(differences, 0, 1), -6.0, kTurnMdeg);
  EXPECT_NEAR(NumberAt(differences, 0, 2), 5.0, 1e-9);
  EXPECT_EQ(TextAt(differences, 0, 8), "not significant");
  EXPECT_EQ(TextAt(differences, 1, 8), "significant");
  EXPECT_EQ(TextAt(differences, 0, 9), "independent");
}

TEST(Comparison, OfOneFlightTheDifferenceOfTheCovariances) {
  const Folder dn("result.json", Result("dn", 0.200, 0.003));
  const Folder gh("result.json", Result("gh", 0.206, 0.005));
  const Document page = MakePage(std::vector{dn.path(), gh.path()});
  const Table& differences = DifferenceRows(page);
  EXPECT_NEAR(NumberAt(differences, 0, 1), -6.0, 0.01);
  EXPECT_NEAR(NumberAt(differences, 0, 2), 4.0, 1e-9);
  EXPECT_EQ(TextAt(differences, 0, 9), "of nested data");
}

Json Match(int pairs) {
  const Json apart = {
      {"rms_m", 1.5},
      {"mean_enu_m", {1.0, 0.5, 0.1}},
      {"separation", {{"to_8_cm", 0.2}, {"8_to_16_cm", 0.3}, {"above_16_cm", 0.5}}}};
  const Json misalignment = pairs > 0 ? Json{{"before", apart}, {"after", apart}} : Json();
  return {{"schema", "dn.match/1"},
          {"flight", "lar3"},
          {"gsd_m", 0.2},
          {"counts", {{"candidates", 9}, {"found", 8}, {"registered", 7}, {"pairs", pairs}}},
          {"misalignment", misalignment},
          {"levels", Json::array()},
          {"strip_pairs",
           {{{"strips", {"1", "2"}},
             {"overlap_m2", 100.0},
             {"counts", {{"candidates", 9}, {"found", 8}, {"registered", 7}, {"pairs", pairs}}},
             {"misalignment", misalignment}}}}};
}

TEST(Page, OfMatchingSaysHowManyPairsThereAreAndHowFarApart) {
  const Folder folder("match.json", Match(6));
  folder.Write("matches/1_2.txt",
               "10, 20, 1, 2, 3, 1, 0.5, 0.1, 0.01, 0, 0, 0.05, 0.05, 0.01, 5\n"
               "11, 21, 5, 2, 3, 1, 0.5, 0.1, 0, 0.01, 0, 0.05, 0.05, 0.01, 5\n");
  folder.Write("swaths.json", R"({"swaths": [{"strip": "1", "line_en_m": [[2, 1], [3, 1]],
      "outline_en_m": [[0, 0], [9, 0], [9, 9]]}]})");
  const Document page = MakePage(folder.path());
  ASSERT_EQ(page.headlines.size(), 1u);
  EXPECT_EQ(page.headlines[0].word, "matched");
  EXPECT_EQ(page.headlines[0].tone, Tone::kGood);
  EXPECT_EQ(NumberAt(page.headlines[0].figures[0], 0, 1), 6.0);
  const Section& apart = page.sections.at(0);
  ASSERT_EQ(apart.contents.size(), 5u);
  const auto& map = std::get<MapChart>(std::get<Chart>(apart.contents[1]));
  EXPECT_EQ(map.valued.x, (std::vector<double>{1.0, 5.0}));
  EXPECT_DOUBLE_EQ(map.valued.value.at(0), std::hypot(1.0, 0.5, 0.1));
  ASSERT_EQ(map.areas.size(), 1u);
  EXPECT_EQ(map.areas[0].label, "strip 1");
  EXPECT_EQ(map.areas[0].y, (std::vector<double>{0.0, 0.0, 9.0}));
  EXPECT_EQ(map.lines.at(0).x, (std::vector<double>{2.0, 3.0}));
}

TEST(Page, OfMatchingHasTheSwathSeparationBeforeAndAfter) {
  const Document page = MakePage(Folder("match.json", Match(6)).path());
  const Section& section = page.sections.at(1);
  EXPECT_EQ(section.title, "Swath separation");
  const Table& table = std::get<Table>(section.contents.at(0));
  ASSERT_EQ(table.rows.size(), 4u);  // two strips and all strips
  EXPECT_EQ(TextAt(table, 0, 0), "1-2");
  EXPECT_EQ(TextAt(table, 2, 0), "all");
  EXPECT_EQ(NumberAt(table, 0, 4), 0.5);
  EXPECT_EQ(std::get<Number>(table.rows[0][4].content).scale, 100.0);
}

Json StripPairs(double before, double after) {
  return {{{"strips", "1-2"},
           {"pairs", 9},
           {"before", {{"separation", {{"to_8_cm", before}}}}},
           {"after", {{"separation", {{"to_8_cm", after}}}}}}};
}

// `before` belongs to the given trajectory, which the Gauss-Helmert adjustment keeps.
TEST(Page, OfAllMethodsHasTheirSwathSeparationsSideBySide) {
  Json dn = Result("dn", 0.2, 0.001), gh = Result("gh", 0.2, 0.001);
  dn["strip_pairs"] = StripPairs(0.2, 0.9);
  gh["strip_pairs"] = StripPairs(0.1, 0.7);
  const Folder folder("result_dn.json", dn);
  folder.Write("result_gh.json", gh.dump());
  const Document page = MakePage(folder.path());
  const Section& section = page.sections.at(1);
  const Table& table = std::get<Table>(section.contents.at(0));
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(TextAt(table, 0, 1), "before");
  EXPECT_EQ(NumberAt(table, 0, 2), 0.1);
  EXPECT_EQ(TextAt(table, 1, 1), "after, dynamic network");
  EXPECT_EQ(NumberAt(table, 1, 2), 0.9);
  EXPECT_EQ(TextAt(table, 2, 1), "after, Gauss-Helmert adjustment");
  EXPECT_EQ(NumberAt(table, 2, 2), 0.7);
}

TEST(Page, OfNewStripsSaysHowFarTheyMovedAndMapsThem) {
  const Folder folder("georef.json", {{"flight", "lar3"},
                                      {"boresight_deg", {0.2, 0.03, 0.35}},
                                      {"strips", {{{"name", "1.las"}, {"shift_rms_m", 1.25}}}}});
  folder.Write("swaths.json", R"({"swaths": [{"strip": "1", "line_en_m": [],
      "outline_en_m": [[0, 0], [9, 0], [9, 9]]}]})");
  const Document page = MakePage(folder.path());
  EXPECT_EQ(page.headlines.at(0).word, "georeferenced");
  const Section& strips = page.sections.at(0);
  EXPECT_EQ(NumberAt(std::get<Table>(strips.contents.at(0)), 0, 3), 1.25);
  const auto& map = std::get<MapChart>(std::get<Chart>(strips.contents.at(1)));
  EXPECT_EQ(map.areas.size(), 1u);
}

/// Returns rows of `columns` numbers; the first column is the time.
std::string Rows(int rows, int columns, double step_s) {
  std::string text;
  for (int k = 0; k < rows; ++k) {
    text += std::to_string(300000.0 + step_s * k);
    for (int c = 1; c < columns; ++c) text += " " + std::to_string(std::sin(0.7 * k + c) + 2.0);
    text += "\n";
  }
  return text;
}

TEST(Page, OfAnHourOfFlightIsSmallEnoughToSend) {
  constexpr std::size_t kMostBytes = 3000000;
  Json result = Result("dn", 0.2, 0.001);
  for (int k = 0; k < 190; ++k) {  // pairs of twenty strips
    result["strip_pairs"].push_back(StripPairs(0.1, 0.9)[0]);
    result["strip_pairs"].back()["strips"] = std::to_string(k);
  }
  const Folder folder("result.json", result);
  folder.Write("trajectory_sigma.txt", Rows(36000, 10, 0.1));
  folder.Write("biases.txt", Rows(36000, 13, 0.1));
  folder.Write("pair_residuals.txt", Rows(40000, 17, 0.09));
  const std::string html = ToHtml(MakePage(folder.path()));
  EXPECT_THAT(html, HasSubstr("Location of the pairs, after"));
  EXPECT_THAT(html, HasSubstr("Gyro, with a band"));
  EXPECT_LT(html.size(), kMostBytes);
}

Json Hits(int hits, int of) {
  return {{"hits", hits}, {"of", of}, {"share", 1.0 * hits / of}, {"interval_95", {0.1, 0.9}}};
}

TEST(Page, OfABlindCheckSaysWhetherThereAreTooManyFalseAlarms) {
  const auto page = [](int alarms) {
    const Json size = {{"from", 0.0},
                       {"detected", Hits(3, 4)},
                       {"named", Hits(2, 4)},
                       {"named_with_group", Hits(2, 4)}};
    const Json bin = {{"low", 0.9}, {"high", 1.0}, {"stated", 0.97}, {"true", Hits(9, 10)}};
    const Folder folder(
        "blind_check.json",
        {{"nothing", {{"false_alarms", Hits(alarms, 10)}, {"allowed_95", {0.0, 0.2}}}},
         {"by_size", {size}},
         {"reliability", {bin}}});
    return MakePage(folder.path());
  };
  EXPECT_EQ(page(1).headlines.at(0).tone, Tone::kGood);
  EXPECT_EQ(page(5).headlines.at(0).tone, Tone::kBad);
  const Document document = page(1);
  const auto& power = std::get<BarChart>(std::get<Chart>(document.sections.at(0).contents.at(0)));
  ASSERT_EQ(power.bars.size(), 3u);
  EXPECT_EQ(power.bars[0].value, 75.0);
  const auto& reliability =
      std::get<SeriesChart>(std::get<Chart>(document.sections.at(1).contents.at(1)));
  EXPECT_EQ(reliability.curves.at(1).x, std::vector<double>{0.97});
  EXPECT_EQ(reliability.curves.at(1).high, std::vector<double>{0.9});
}

TEST(Page, OfASweepHasTheBestDesignFirst) {
  const Json designs = {
      {{"labels", {"one"}}, {"singular", "the boresight is not observable"}},
      {{"labels", {"two"}}, {"singular", ""}, {"sigma_deg", {0.003, 0.002, 0.009}}},
      {{"labels", {"cross"}}, {"singular", ""}, {"sigma_deg", {0.001, 0.001, 0.002}}}};
  const Document page =
      MakePage(Folder("sweep.json", {{"keys", {"plan.lines"}}, {"designs", designs}}).path());
  EXPECT_EQ(page.headlines.at(0).answer,
            "2 of them would determine the boresight. The best: cross");
  const Table& table = std::get<Table>(page.sections.at(0).contents.at(1));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(TextAt(table, 1, 0), "two");
  EXPECT_EQ(page.sections.at(2).title, "Designs that determine nothing");
}

TEST(Page, OfMatchingWithoutPairsSaysSoFirst) {
  const Document page = MakePage(Folder("match.json", Match(0)).path());
  EXPECT_EQ(page.headlines.at(0).word, "no pairs");
  EXPECT_EQ(page.headlines.at(0).tone, Tone::kBad);
  EXPECT_EQ(page.sections.at(0).title, "Stages");
}

/// Returns a result with pairs of strips of these names.
Json WithStripPairs(const std::vector<std::string>& names) {
  Json result = Result("dn", 0.2, 0.001);
  for (const std::string& name : names) {
    result["strip_pairs"].push_back(
        {{"strips", name}, {"pairs", 10}, {"after", {{"separation", {{"to_8_cm", 1.0}}}}}});
  }
  return result;
}

void ExpectRefused(const Folder& folder, const std::string& message) {
  try {
    MakePage(folder.path());
    FAIL() << "no refusal";
  } catch (const InvalidInput& error) {
    const std::string text = std::string(error.what()) + " (" + error.where().ToString() + ")";
    EXPECT_THAT(text, HasSubstr(message));
  }
}

TEST(Page, APairOfStripsIsThereOnce) {
  const Folder good("result.json", WithStripPairs({"1 2", "1 3"}));
  EXPECT_NO_THROW(MakePage(good.path()));
  const Folder twice("result.json", WithStripPairs(std::vector<std::string>(1000, "1 2")));
  ExpectRefused(twice, "strip_pairs has '1 2' twice");
}

TEST(Page, ShowsABoundedNumberOfRows) {
  Json result = Result("dn", 0.2, 0.001);
  result["strip_pairs"] = std::vector<Json>(150'000, Json::object());
  ExpectRefused(Folder("result.json", result), "more rows than a page can show");
  result = Result("dn", 0.2, 0.001);
  result["estimates"] = {{"a", {{"value", std::vector<int>(150'000, 0)}}}};
  ExpectRefused(Folder("result.json", result), "more rows than a page can show");
  Json report = Report();
  report["warnings"] = std::vector<std::string>(20'000, "x");
  ExpectRefused(Folder("result.json", Result("dn", 0.2, 0.001), report), "more texts than a page");
}

TEST(Page, WhatIsNoRegularFileIsRefusedByName) {
  Folder folder("result.json", Json());
  std::filesystem::remove(folder.path() / "result.json");
  std::filesystem::create_directory(folder.path() / "result.json");
  ExpectRefused(folder, "this is a folder, not a regular file");
  std::filesystem::remove(folder.path() / "result.json");
  std::filesystem::create_symlink("/dev/zero", folder.path() / "result.json");
  ExpectRefused(folder, "this is a device, not a regular file");
}

TEST(Page, NamesTheFileThatIsNoJson) {
  Folder folder("result.json", Json());
  folder.Write("result.json", "{\"boresight\":\n [}");
  ExpectRefused(folder, "result.json:2:3");
  folder.Write("result.json", std::string(1'000'000, '['));
  ExpectRefused(folder, "nested deeper");
}

}  // namespace dn::page_test
