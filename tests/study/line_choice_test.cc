#include <dn/error.h>
#include <dn/study/line_choice.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <fstream>
#include <utility>
#include <vector>

#include "study/small_designs.h"
#include "testing/temp_folder.h"

namespace dn::testing::study_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kLines =
    "  east: [-600, 0, 600, 0, 200, 45]\n"
    "  west: [600, 60, -600, 60, 200, 45]\n"
    "  across: [0, -600, 0, 600, 240, 45]\n"
    "  long: [-1200, 30, 1200, 30, 200, 45]\n";

/// Candidate lines on the small scenario, which is in the folder of their file.
struct SmallCandidates {
  TempFolder folder;
  std::string where = (folder.path() / "candidates.yaml").string();

  SmallCandidates() { std::ofstream(folder.path() / "two.yaml") << kTwoStrips; }
  LineCandidates Parse(const std::string& target, const std::string& lines = kLines) const {
    return LineCandidates::Parse("base: two.yaml\ntarget_deg: " + target + "\nlines:\n" + lines,
                                 where);
  }
};

std::string ParseErrorText(const std::string& target, const std::string& lines) {
  try {
    SmallCandidates().Parse(target, lines);
  } catch (const InvalidConfig& error) {
    return error.what();
  }
  return "no error";
}

/// A choice of lines with its flight time and the sigmas of its boresight.
struct StudiedChoice {
  std::vector<std::size_t> lines;
  double time_s = 0.0;
  Eigen::Array3d sigma_rad;
};

/// Studies every choice of at least two lines that determines the boresight.
std::vector<StudiedChoice> StudyEveryChoice(const LineCandidates& candidates) {
  std::vector<StudiedChoice> all;
  const std::size_t n = candidates.names.size();
  for (unsigned bits = 1; bits < 1u << n; ++bits) {
    std::vector<std::size_t> lines;
    for (std::size_t k = 0; k < n; ++k) {
      if ((bits >> k & 1u) != 0) lines.push_back(k);
    }
    if (lines.size() < 2) continue;
    StudyOptions options;
    options.remedies = false;
    const StudyResult study = Study(candidates.With(lines), options);
    if (!study.observable()) continue;
    all.push_back({std::move(lines), study.trajectory.back().t_s - study.trajectory.front().t_s,
                   study.boresight.sigma_rad()});
  }
  return all;
}

/// Returns the shortest choice whose sigmas meet the target.
std::vector<std::size_t> Shortest(const std::vector<StudiedChoice>& all,
                                  const Eigen::Vector3d& target_rad) {
  const StudiedChoice* best = nullptr;
  for (const StudiedChoice& choice : all) {
    if ((choice.sigma_rad > target_rad.array()).any()) continue;
    if (best == nullptr || choice.time_s < best->time_s) best = &choice;
  }
  return best == nullptr ? std::vector<std::size_t>{} : best->lines;
}

TEST(LineChoiceManyRuns, FindsTheShortestFlightThatMeetsTheTarget) {
  const SmallCandidates small;
  const std::vector<StudiedChoice> all = StudyEveryChoice(small.Parse("[1, 1, 1]"));
  for (const char* target : {"[0.03, 0.03, 0.06]", "[0.025, 0.02, 0.03]"}) {
    SCOPED_TRACE(target);
    const LineCandidates candidates = small.Parse(target);
    const LineSearch search = ChooseLines(candidates);
    ASSERT_GE(search.best, 0);
    const LineChoice& best = search.studied[static_cast<std::size_t>(search.best)];
    EXPECT_EQ(best.lines, Shortest(all, candidates.target_rad));
    EXPECT_LE(best.WorstRatio(candidates.target_rad), 1.0);
  }
}

TEST(LineChoiceManyRuns, IsTheSameForAnyNumberOfThreads) {
  const SmallCandidates small;
  const LineCandidates candidates = small.Parse("[0.03, 0.03, 0.06]");
  LineSearchOptions two;
  two.design.threads = 2;
  EXPECT_EQ(ToJson(candidates, ChooseLines(candidates)).dump(),
            ToJson(candidates, ChooseLines(candidates, two)).dump());
}

TEST(LineChoice, SaysWhichAngleMissesWithAllLines) {
  const SmallCandidates small;
  const LineCandidates candidates = small.Parse("[1, 1, 1e-7]");
  const LineSearch search = ChooseLines(candidates);
  EXPECT_LT(search.best, 0);
  ASSERT_EQ(search.studied.size(), 1u);
  EXPECT_THAT(MissedTarget(candidates, search), HasSubstr("yaw"));
  EXPECT_THAT(LineSearchSummary(candidates, search), HasSubstr("not even all lines"));
}

TEST(LineChoice, EachLineHasThePairsOfTheBase) {
  const SmallCandidates small;
  const LineCandidates candidates = small.Parse("[1, 1, 1]");
  EXPECT_THAT(candidates.names, ElementsAre("east", "west", "across", "long"));
  const Scenario scenario = candidates.With({0, 2, 3});
  EXPECT_EQ(scenario.pairs.count, 900);
  ASSERT_EQ(scenario.plan.lines.size(), 3u);
  EXPECT_EQ(scenario.plan.lines[1].height_m, 240.0);
}

TEST(LineChoice, RefusesWhatIsNone) {
  EXPECT_THAT(ParseErrorText("[1, 1, 1]", "  one: [-600, 0, 600, 0, 200, 45]\n"),
              HasSubstr("has 1 lines"));
  EXPECT_THAT(ParseErrorText("[1, 1, 0]", kLines), HasSubstr("target_deg"));
  EXPECT_THAT(ParseErrorText("[1, 1, 1]", "  one: [-600, 0, 600]\n  two: [0, 0, 1, 1, 200, 45]\n"),
              HasSubstr("these lines do not fit the base"));
  EXPECT_THAT(ParseErrorText("[1, 1, 1]\nanother: 1", kLines), HasSubstr("another"));
  EXPECT_THAT(ParseErrorText("[1, 1, 1]\nestimate: [gnss_lever_arn]", kLines),
              HasSubstr("did you mean 'gnss_lever_arm'?"));
}

}  // namespace dn::testing::study_test
