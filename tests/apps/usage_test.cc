#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kSubcommands[] = {"check",     "simulate", "smooth",
                                        "calibrate", "allan",    "monte-carlo"};

class EverySubcommand : public ::testing::TestWithParam<const char*> {
 protected:
  // With what the subcommand requires.
  static std::vector<std::string> Complete(const std::vector<std::string>& options) {
    const std::string name = GetParam();
    std::vector<std::string> arguments{name, "x", "--out", "y"};
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

TEST(CliUsage, NothingAtAllIsWrongUsage) {
  const ProgramRun run = RunProgram(std::vector<std::string>{});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("subcommand"));
}

TEST(CliUsage, UnknownSubcommand) {
  const ProgramRun run = RunProgram({"calibrat", "x", "--out", "y"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, Not(IsEmpty()));
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

TEST(CliUsage, AMethodOfALaterVersionIsRefusedInOneLine) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"calibrate", ShortFlight().string(), "--method", "planes",
                                     "--out", (folder.path() / "r").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(
      run.err,
      "dn calibrate: error: --method planes is not part of this version; use dn, gh or all\n");
  EXPECT_EQ(NamesIn(folder.path() / "r"), std::vector<std::string>{"report.json"});
}

TEST(CliUsage, UnknownScenarioNamesTheNearest) {
  const TempFolder folder;
  const ProgramRun run = RunProgram({"simulate", "lar33", "--out", (folder.path() / "f").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("'lar33'"));
  EXPECT_THAT(run.err, HasSubstr("nearest one is 'lar3'"));
}

}  // namespace
}  // namespace dn::testing
