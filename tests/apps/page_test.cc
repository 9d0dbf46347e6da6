#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "page_numbers.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

std::string PageIn(const fs::path& folder) { return FileContent(folder / "report.html"); }

TEST(CliPage, NumbersAreThoseOfTheFiles) {
  ExpectPageMatchesFiles(CalibrateResult(), 150);
  ExpectPageMatchesFiles(SmoothResult(), 100);
  ExpectPageMatchesFiles(GapResult(), 100);
  ExpectPageMatchesFiles(CheckResult(), 3);
  ExpectPageMatchesFiles(ShortFlight(), 3);
}

TEST(CliPage, ItsFirstScreenAnswers) {
  const std::string html = PageIn(CalibrateResult());
  const Json result = Json::parse(FileContent(CalibrateResult() / "result.json"));
  const std::string verdict = result["assessment"]["verdict"];
  const std::string first = html.substr(0, html.find("<nav>"));
  EXPECT_THAT(first,
              AllOf(HasSubstr("<h2>" + verdict + "</h2>"), HasSubstr("You may rely"),
                    HasSubstr("result.json#/boresight/sigma_deg/2"), HasSubstr("What to do next")));
}

TEST(CliPage, HoldsEverySection) {
  const std::string html = PageIn(CalibrateResult());
  for (const char* text :
       {"Differences of the pairs by pair of strips", "USGS", "Swath separation",
        "Location of the pairs, before", "Remaining differences of the pairs against scan angle",
        "against range", "against heading", "against time", "Does the model fit the data?",
        "Path of the flight", "Standard deviation of the attitude",
        "Gyro, with a band of one sigma", "Settings (config.resolved.yaml)", "Versions"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
}

TEST(CliPage, OfAFolderIsThatOfTheCommand) {
  const TempFolder folder;
  const fs::path page = folder.path() / "page.html";
  for (const fs::path& result : {CalibrateResult(), SmoothResult(), GapResult(), CheckResult()}) {
    const ProgramRun run = RunProgram({"report", result.string(), "--out", page.string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(FileContent(page) == PageIn(result)) << result;
  }
}

TEST(CliPage, SeveralResultsSideBySide) {
  const TempFolder folder;
  const std::string gh = (folder.path() / "gh").string();
  const fs::path page = folder.path() / "page.html";
  ASSERT_EQ(RunProgram({"calibrate", ShortFlight().string(), "--method", "gh", "--trajectory",
                        (SmoothResult() / "trajectory.out").string(), "--out", gh})
                .exit_code,
            0);
  const ProgramRun run =
      RunProgram({"report", CalibrateResult().string(), gh, "--out", page.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("not significant"), HasSubstr("of nested data")));
  EXPECT_THAT(FileContent(page), AllOf(HasSubstr("Do they agree?"), HasSubstr("of nested data")));
  const ProgramRun again = RunProgram(
      {"report", CalibrateResult().string(), CalibrateResult().string(), "--out", page.string()});
  EXPECT_THAT(again.out, HasSubstr("independent"));
}

// The expected hash is the output of sha256sum for the ten bytes.
TEST(CliPage, NamesItsInputsByTheirHashes) {
  const std::string hash = "bb3f6e853581c6e91d279993712aab3c699befcad00ad93f8b375590ac395472";
  const TempFolder flight, out;
  flight.Write("flight.yaml", "name: abc\n");
  flight.Write("strips/1.txt", "no point cloud\n");  // dn check does not read the points
  ASSERT_EQ(RunProgram({"check", flight.path().string(), "--out", out.path().string()}).exit_code,
            0);
  const Json expected = {{{"file", "flight.yaml"}, {"bytes", 10}, {"sha256", hash}}};
  EXPECT_EQ(Json::parse(FileContent(out.path() / "report.json"))["inputs"], expected);
  EXPECT_THAT(PageIn(out.path()),
              AllOf(HasSubstr("<td class=\"plain\">" + hash.substr(0, 12) + "</td>"),
                    HasSubstr(hash + "  flight.yaml")));
}

TEST(CliPage, ListsEveryInputOfACalibration) {
  const Json report = Json::parse(FileContent(CalibrateResult() / "report.json"));
  std::vector<std::string> files;
  for (const Json& input : report["inputs"]) {
    const std::string file = input["file"];
    files.push_back(file);
    EXPECT_EQ(input["bytes"], fs::file_size(ShortFlight() / file)) << file;
  }
  EXPECT_THAT(files,
              ::testing::IsSupersetOf({"flight.yaml", "IMU.txt", "GPS.txt", "lidar/1_2.txt"}));
}

TEST(CliPage, WhatIsNoResultIsRefused) {
  const TempFolder folder;
  const std::string page = (folder.path() / "page.html").string();
  const ProgramRun none = RunProgram({"report", folder.path().string(), "--out", page});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("not a result folder of dn"));
  EXPECT_FALSE(fs::exists(page));
  const ProgramRun json = RunProgram({"report", CalibrateResult().string(), "--out",
                                      (CalibrateResult() / "result.json").string()});
  EXPECT_EQ(json.exit_code, 2);
  EXPECT_THAT(json.err, HasSubstr(".html"));
}

TEST(CliPage, AFailureIsSaid) {
  const TempFolder folder;
  folder.Write("report.json", R"({"schema": "dn.report/1", "command": "calibrate",
      "versions": {"dn": "0"}, "error": {"kind": "input", "message": "</script>no IMU data"}})");
  const std::string page = (folder.path() / "page.html").string();
  const ProgramRun run = RunProgram({"report", folder.path().string(), "--out", page});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(FileContent(page),
              AllOf(HasSubstr("failed"), HasSubstr("no IMU data"), Not(HasSubstr("</script>no"))));
}

}  // namespace dn::testing::apps_test
