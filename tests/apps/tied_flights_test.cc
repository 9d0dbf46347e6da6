#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "between_pairs.h"
#include "load_json.h"
#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

const Eigen::Vector3d kBoresight_deg(0.2, 0.03, 0.35);

/// Two flights with pairs between them. They are calibrated once with these pairs.
class CliTiedFlights : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    for (const char* seed : {"31", "32"}) {
      RunProgram({"simulate", ShortScenario().string(), "--seed", seed, "--out",
                  Path(seed).string(), "--set", std::string("name=day ") + seed});
    }
    WriteBetween("matched", Eigen::Vector3d::Zero());
    run_ = new ProgramRun(Calibrate("tied", {"--between", Path("matched").string()}));
  }
  static void TearDownTestSuite() {
    delete run_;
    delete folder_;
  }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }

  static void WriteBetween(const std::string& folder, const Eigen::Vector3d& apart_e_m) {
    const TrueFlight first(Path("31"), kBoresight_deg), second(Path("32"), kBoresight_deg);
    folder_->Write(folder + "/between_day_31_day_32/1_1.txt",
                   FormatPairs(BetweenPairs(first, second, 2, 0.03, apart_e_m, 5)));
  }

  static ProgramRun Calibrate(const std::string& out, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"calibrate", Path("31").string(), Path("32").string(),
                                       "--out", Path(out).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  static Json Result(const std::string& out) { return LoadJson(Path(out) / "result.json"); }

  inline static TempFolder* folder_ = nullptr;
  inline static ProgramRun* run_ = nullptr;
};

TEST_F(CliTiedFlights, PairsBetweenFlightsMakeTheSigmasSmaller) {
  ASSERT_EQ(run_->exit_code, 0) << run_->err;
  ASSERT_EQ(Calibrate("alone").exit_code, 0);
  const Json tied = Result("tied"), alone = Result("alone");
  EXPECT_EQ(tied["ties"]["used"].get<int>() + tied["ties"]["strips"][0]["rejected"].get<int>(),
            100);
  EXPECT_EQ(tied["ties"]["strips"][0]["pairs"], "between_day_31_day_32/1_1.txt");
  EXPECT_FALSE(alone.contains("ties"));
  for (std::size_t i = 0; i < 3; ++i) {
    const Json &with = tied["boresight"], &without = alone["boresight"];
    EXPECT_LT(with["sigma_deg"][i], without["sigma_deg"][i]);
    EXPECT_LT(with["as_modelled"]["sigma_deg"][i].get<double>(),
              without["as_modelled"]["sigma_deg"][i].get<double>());
    EXPECT_LT(std::abs(with["angles_deg"][i].get<double>() - kBoresight_deg[static_cast<int>(i)]),
              4.0 * with["sigma_deg"][i].get<double>());
  }
  EXPECT_THAT(run_->out, HasSubstr("pairs between flights: "));
  EXPECT_THAT(FileContent(Path("tied") / "report.html"), HasSubstr("Pairs between flights"));
}

TEST_F(CliTiedFlights, TiesDoNotMoveAFlight) {
  ASSERT_EQ(Calibrate("alone").exit_code, 0);
  const std::string file = "/day_31/reduced.json";
  const Json tied = LoadJson(Path("tied" + file)), alone = LoadJson(Path("alone" + file));
  EXPECT_NE(tied["made_from"], alone["made_from"]);
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = std::sqrt(alone["as_modelled"]["covariance_rad2"][i][i].get<double>());
    EXPECT_NEAR(tied["as_modelled"]["angles_rad"][i].get<double>(),
                alone["as_modelled"]["angles_rad"][i].get<double>(), 1e-3 * sigma);
    EXPECT_NEAR(std::sqrt(tied["as_modelled"]["covariance_rad2"][i][i].get<double>()), sigma,
                1e-4 * sigma);
    // The sizes of shared errors come from random samples, which the rows of the ties change.
    const double reported = std::sqrt(alone["covariance"][i][i].get<double>());
    EXPECT_NEAR(std::sqrt(tied["covariance"][i][i].get<double>()), reported, 0.05 * reported);
  }
}

TEST_F(CliTiedFlights, NoFlightIsCalibratedTwice) {
  const fs::path file = Path("tied") / "day_31" / "result.json";
  const auto before = fs::last_write_time(file);
  EXPECT_EQ(Calibrate("tied", {"--between", Path("matched").string()}).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(file), before);
}

TEST_F(CliTiedFlights, ResultFoldersKeepTheirTies) {
  const ProgramRun run =
      RunProgram({"calibrate", (Path("tied") / "day_31").string(),
                  (Path("tied") / "day_32").string(), "--out", Path("combined").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Result("combined")["boresight"], Result("tied")["boresight"]);
}

TEST_F(CliTiedFlights, GroundThatIsApartContradicts) {
  WriteBetween("apart", {0.3, 0.3, 0.0});
  const ProgramRun run = Calibrate("apart_result", {"--between", Path("apart").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("flights day 31 and day 32 see the same ground"));
  EXPECT_EQ(Result("apart_result")["assessment"]["verdict"], "contradicted");
}

TEST_F(CliTiedFlights, BadPairsGetAClearError) {
  const ProgramRun empty = Calibrate("refused", {"--between", Path("31").string()});
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_THAT(empty.err, HasSubstr("has no pairs between these flights"));
  const ProgramRun one = RunProgram({"calibrate", Path("31").string(), "--between",
                                     Path("matched").string(), "--out", Path("refused").string()});
  EXPECT_EQ(one.exit_code, 2);
  EXPECT_THAT(one.err, HasSubstr("are for several flights"));
  const ProgramRun onto = Calibrate("matched", {"--between", Path("matched").string()});
  EXPECT_EQ(onto.exit_code, 2);
  EXPECT_THAT(onto.err, HasSubstr("is a folder of the input data"));
  folder_->Write("broken/between_day_31_day_32/1_1.txt", "381200, 381300, 1, 2\n");
  const ProgramRun broken = Calibrate("refused", {"--between", Path("broken").string()});
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_THAT(broken.err, HasSubstr("1_1.txt:1"));
}

}  // namespace dn::testing::apps_test
