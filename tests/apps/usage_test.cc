#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kSubcommands[] = {"init",        "check", "simulate", "smooth",
                                        "calibrate",   "gap",   "allan",    "monte-carlo",
                                        "blind-check", "merge", "report",   "georef"};

class EverySubcommand : public ::testing::TestWithParam<const char*> {
 protected:
  // Adds the arguments that the subcommand requires.
  static std::vector<std::string> Complete(const std::vector<std::string>& options) {
    const std::string name = GetParam();
    std::vector<std::string> arguments{name, "--out", "y.html"};
    if (name != "blind-check") arguments.insert(arguments.begin() + 1, "x");
    if (name == "allan") arguments.insert(arguments.end(), {"--rate", "200"});
    arguments.insert(arguments.end(), options.begin(), options.end());
    return arguments;
  }
};

TEST_P(EverySubcommand, HelpGoesToStdoutAndShowsAnExample) {
  const ProgramRun run = RunProgram({GetParam(), "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("--out"));
  EXPECT_THAT(run.out, HasSubstr("--threads"));
  EXPECT_THAT(run.out, HasSubstr(std::string("Example: dn ") + GetParam()));
  EXPECT_THAT(run.err, IsEmpty());
}

TEST_P(EverySubcommand, Version) {
  const ProgramRun run = RunProgram({GetParam(), "--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "dn " DN_VERSION "\n");
}

TEST_P(EverySubcommand, WithoutItsArgumentIsWrongUsage) {
  const ProgramRun run = RunProgram({GetParam()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, HasSubstr("is required"));
}

TEST_P(EverySubcommand, RefusesAnUnknownOption) {
  const ProgramRun run = RunProgram(Complete({"--no-such-option"}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--no-such-option"));
}

TEST_P(EverySubcommand, RefusesNoThreads) {
  for (const char* threads : {"0", "-1", "many"}) {
    const ProgramRun run = RunProgram(Complete({"--threads", threads}));
    EXPECT_EQ(run.exit_code, 2) << threads;
    EXPECT_THAT(run.err, HasSubstr("--threads")) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(Cli, EverySubcommand, ::testing::ValuesIn(kSubcommands),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(CliUsage, HelpNamesEverySubcommand) {
  const ProgramRun run = RunProgram({"--help"});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* name : kSubcommands) {
    EXPECT_THAT(run.out, HasSubstr(name));
  }
}

TEST(CliUsage, Version) {
  const ProgramRun run = RunProgram({"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "dn " DN_VERSION "\n");
}

TEST(CliUsage, ResultsNeedAFolder) {
  for (const char* name : {"simulate", "smooth", "calibrate"}) {
    const ProgramRun run = RunProgram({name, ShortFlight().string()});
    EXPECT_EQ(run.exit_code, 2) << name;
    EXPECT_THAT(run.err, HasSubstr("--out")) << name;
  }
}

TEST(CliUsage, AnEmptyFolderNameIsWrongUsage) {
  const ProgramRun run = RunProgram({"calibrate", ShortFlight().string(), "--out", ""});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--out"));
}

TEST(CliUsage, SeedsAreWholeAndNotNegative) {
  const TempFolder folder;
  for (const char* seed : {"-1", "1.5", "one"}) {
    const ProgramRun run = RunProgram({"simulate", ShortScenario().string(), "--seed", seed,
                                       "--out", (folder.path() / "f").string()});
    EXPECT_EQ(run.exit_code, 2) << seed;
    EXPECT_THAT(run.err, HasSubstr("--seed")) << seed;
  }
}

TEST(CliUsage, UnknownMethodNamesTheKnownOnes) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"calibrate", ShortFlight().string(), "--method", "ghh",
                                     "--out", (folder.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("dn"));
  EXPECT_THAT(run.err, HasSubstr("ghh"));
}

TEST(CliUsage, PlanesWithoutATrajectorySayHowToGetOne) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"calibrate", ShortFlight().string(), "--method", "planes",
                                     "--out", (folder.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("the plane adjustment needs one; make it with `dn smooth"));
  EXPECT_EQ(NamesIn(folder.path() / "r"), std::vector<std::string>{"report.json"});
}

/// Expects exit code 2 and exactly this line on stderr.
void ExpectUsageError(const ProgramRun& run, const std::string& line) {
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_EQ(run.err, line + "\n");
}

TEST(CliUsage, WrongUsageIsOneErrorLine) {
  const std::string see = "; see dn simulate --help";
  ExpectUsageError(RunProgram({"simulate"}), "dn simulate: error: SCENARIO is required" + see);
  ExpectUsageError(RunProgram({"simulate", "lar3"}), "dn simulate: error: --out is required" + see);
  ExpectUsageError(RunProgram({"simulate", "lar3", "--out"}),
                   "dn simulate: error: --out takes one value, given once" + see);
  ExpectUsageError(RunProgram({"simulate", "lar3", "--out", "x", "--out", "y"}),
                   "dn simulate: error: --out takes one value, given once" + see);
  ExpectUsageError(RunProgram({"simulate", "lar3", "--out", "x", "--noise-free=often"}),
                   "dn simulate: error: --noise-free takes no value" + see);
  ExpectUsageError(RunProgram({"simulate", "lar3", "uav3", "--out", "x"}),
                   "dn simulate: error: 'uav3' is one argument too many" + see);
  ExpectUsageError(
      RunProgram({"simulate", "lar3", "--out", "x", "--sed=3"}),
      "dn simulate: error: '--sed' is not an option; the nearest one is '--seed'" + see);
}

TEST(CliUsage, WithoutACommandTheCommandsAreNamed) {
  ExpectUsageError(
      RunProgram(std::vector<std::string>{}),
      "dn: error: a command is required: init, check, calibrate, smooth, simulate, study, "
      "match, georef, gap, monte-carlo, blind-check, merge, allan, report, completion; see dn "
      "--help");
  ExpectUsageError(RunProgram({"calibrat", "x"}),
                   "dn: error: 'calibrat' is not a command; the nearest one is 'calibrate'; see dn "
                   "--help");
  ExpectUsageError(RunProgram({"--versio"}),
                   "dn: error: '--versio' is not an option; the nearest one is '--version'; see dn "
                   "--help");
}

TEST(CliUsageManyRuns, NumbersAreRefusedWithTheirBound) {
  const std::vector<std::string> monte_carlo{"monte-carlo", "lar3", "--out", "x"};
  const auto expect = [&](std::vector<std::string> arguments, const std::string& option,
                          const std::string& value, const std::string& what) {
    arguments.insert(arguments.end(), {option, value});
    const std::string name = "dn " + arguments.front();
    ExpectUsageError(RunProgram(arguments), name + ": error: " + option + ": '" + value + "' is " +
                                                what + "; see " + name + " --help");
  };
  for (const char* value : {"x", "-1", "0", "nan", "inf", "1e999", "", "1 2"}) {
    expect({"allan", "IMU.txt", "--out", "x"}, "--rate", value, "not a number above 0");
    expect(monte_carlo, "--epoch-spacing", value, "not a number above 0");
  }
  for (const char* value : {"x", "-1", "0.5", "1e30", "18446744073709551616", ""}) {
    expect(monte_carlo, "--seed", value, "not an integer from 0 to 2^64 - 1");
  }
  for (const char* value : {"x", "0", "1000001"}) {
    expect(monte_carlo, "--flights", value, "not an integer from 1 to 1000000");
  }
  for (const char* value : {"x", "0", "1025"}) {
    expect(monte_carlo, "--threads", value, "not an integer from 1 to 1024");
  }
}

TEST(CliUsage, LongWordsAreShownByTheirBegin) {
  const std::string word(5000, '9');
  const std::string shown = "'" + word.substr(0, 60) + "...'";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"check", "f", "--threads", word},
        std::vector<std::string>{"calibrate", "f", "--out", "x", "--method", word},
        std::vector<std::string>{"check", "f", word}, std::vector<std::string>{word}}) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr(shown));
    EXPECT_LT(run.err.size(), 200U);
  }
  const ProgramRun run = RunProgram({"check", word});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("File name too long"));
  EXPECT_LT(run.err.size(), 500U);
}

TEST(CliUsage, ControlCharactersReachNoTerminal) {
  const std::string word = "a\x1b[2J\nb\x7f\xc2\x9b\xff\xc3\xa9";
  const std::string shown = "a\\x1B[2J\\x0Ab\\x7F\\xC2\\x9B\\xFF\xc3\xa9";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{word}, std::vector<std::string>{"--" + word},
        std::vector<std::string>{"check", word}, std::vector<std::string>{"check", "f", word},
        std::vector<std::string>{"simulate", "lar3", "--out", "x", "--seed", word}}) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr(shown));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, Not(HasSubstr("\x1b")));
  }
}

TEST(CliUsage, ErrorsNameTheFileHoweverShortItsName) {
  const TempFolder folder;
  const ProgramRun run =
      RunProgram({"allan", "i", "--rate", "1", "--out", (folder.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("dn allan: error: file does not exist (i)\n"));
}

TEST(CliUsage, SimulateListsTheShippedScenarios) {
  const ProgramRun run = RunProgram({"simulate", "--help"});
  for (const char* name : {"  leg2", "  lar2_cross", "  hal4_rest", "  lar3_effects"}) {
    EXPECT_THAT(run.out, HasSubstr(name));
  }
}

TEST(CliUsage, UnknownScenarioNamesTheNearest) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"simulate", "lar33", "--out", (folder.path() / "f").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("'lar33'"));
  EXPECT_THAT(run.err, HasSubstr("did you mean 'lar3'"));
}

}  // namespace dn::testing::apps_test
