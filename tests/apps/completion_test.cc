#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;

/// Returns the completions that bash offers for the last word of a command line.
std::string Offered(const std::filesystem::path& folder, const std::string& words, int last) {
  std::ofstream(folder / "dn.bash") << RunProgram({"completion", "bash"}).out;
  const std::string line = "bash --norc -c 'source " + (folder / "dn.bash").string() +
                           "; COMP_WORDS=(" + words + "); COMP_CWORD=" + std::to_string(last) +
                           "; _dn; echo \"${COMPREPLY[@]}\"' > " + (folder / "offered").string();
  EXPECT_EQ(std::system(line.c_str()), 0);
  return FileContent(folder / "offered");
}

TEST(Completion, OfCommandsAndOptions) {
  const TempFolder folder;
  EXPECT_EQ(Offered(folder.path(), "dn cal", 1), "calibrate\n");
  EXPECT_EQ(Offered(folder.path(), "dn calibrate --me", 2), "--method\n");
  EXPECT_EQ(Offered(folder.path(), "dn calibrate flight --thr", 3), "--threads\n");
  EXPECT_EQ(Offered(folder.path(), "dn calibrate fli", 2), "\n") << "files are for bash";
}

TEST(Completion, OfZshThroughThatOfBash) {
  const std::string bash = RunProgram({"completion", "bash"}).out;
  EXPECT_EQ(RunProgram({"completion", "zsh"}).out,
            "autoload -U +X bashcompinit && bashcompinit\n" + bash);
  const ProgramRun fish = RunProgram({"completion", "fish"});
  EXPECT_EQ(fish.exit_code, 2);
  EXPECT_THAT(fish.err, HasSubstr("fish"));
}

}  // namespace dn::testing::apps_test
