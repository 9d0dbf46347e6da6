#include "forward_selection.h"

#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

namespace dn::diagnosis_internal {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr EffectId kRange = EffectId::kLidarRangeOffset, kArm = EffectId::kGnssLeverArm,
                   kNoise = EffectId::kP2pNoiseScale;
constexpr double kThresholdNats = 6.0;

/// Evidence, nats, of each effect that the data show with some effects in the model.
using Evidence = std::map<EffectId, double>;

/// Data whose fits are known: the evidence of the missing effects for each set of chosen ones.
class KnownFits {
 public:
  explicit KnownFits(std::map<std::set<EffectId>, Evidence> fits) : fits_(std::move(fits)) {}

  std::unique_ptr<ExtendedFit> Fit(const std::vector<HypothesisEvidence>& chosen) {
    std::set<EffectId> ids;
    for (const HypothesisEvidence& effect : chosen) ids.insert(*effect.id);
    ++count_;
    if (!fits_.contains(ids)) throw InvalidInput("the data cannot be fitted");
    auto fit = std::make_unique<ExtendedFit>();
    fit->chosen = chosen;
    for (const auto& [id, nats] : fits_.at(ids)) {
      HypothesisEvidence effect{MakeHypothesis(id), {}};
      effect.log_evidence = nats;
      effect.estimate = effect.sigma = Eigen::VectorXd::Ones(effect.typical.size());
      fit->effects.push_back(std::move(effect));
    }
    SortByEvidence(&fit->effects);
    return fit;
  }

  ForwardSelection Select(SelectionPolicy policy = {}) {
    policy.threshold_nats = kThresholdNats;
    policy.next = BestPhysical;
    return {policy, [this](const auto& chosen) { return Fit(chosen); }, Fit({})};
  }

  int count() const { return count_; }

 private:
  std::map<std::set<EffectId>, Evidence> fits_;
  int count_ = 0;
};

std::vector<std::string> Names(const std::vector<HypothesisEvidence>& effects) {
  std::vector<std::string> names;
  for (const HypothesisEvidence& effect : effects) names.push_back(effect.name);
  return names;
}

TEST(ForwardSelection, AddsEffectsUntilTheEvidenceIsTooWeak) {
  KnownFits fits({{{}, {{kRange, 30.0}, {kArm, 20.0}, {kNoise, 5.0}}},
                  {{kRange}, {{kArm, 12.0}, {kNoise, 3.0}}},
                  {{kRange, kArm}, {{kNoise, 5.9}}}});
  ForwardSelection selection = fits.Select();
  selection.Grow();
  const Selection found = selection.Take();
  EXPECT_THAT(Names(found.chosen), ElementsAre("lidar_range_offset", "gnss_lever_arm"));
  EXPECT_EQ(found.explained_nats, 42.0);
  ASSERT_NE(found.final, nullptr);
  EXPECT_EQ(found.final->chosen.size(), 2u);
}

TEST(ForwardSelection, StopsAtTheMostEffects) {
  KnownFits fits({{{}, {{kRange, 30.0}, {kArm, 20.0}}}, {{kRange}, {{kArm, 12.0}}}});
  SelectionPolicy policy;
  policy.most = 1;
  ForwardSelection selection = fits.Select(policy);
  selection.Grow();
  EXPECT_THAT(Names(selection.Take().chosen), ElementsAre("lidar_range_offset"));
}

TEST(ForwardSelection, NamesTheFirstEffectWithoutAFit) {
  KnownFits fits({{{}, {{kRange, 30.0}, {kArm, 20.0}}}});
  SelectionPolicy policy;
  policy.refits = false;
  ForwardSelection selection = fits.Select(policy);
  selection.Grow();
  const Selection found = selection.Take();
  EXPECT_THAT(Names(found.chosen), ElementsAre("lidar_range_offset"));
  EXPECT_EQ(found.final, nullptr);
  EXPECT_EQ(&found.last(), found.base.get());
  EXPECT_EQ(fits.count(), 1);
}

TEST(ForwardSelection, NotesAnEffectThatCannotBeFitted) {
  KnownFits fits({{{}, {{kRange, 30.0}}}});
  ForwardSelection selection = fits.Select();
  selection.Grow();
  const Selection found = selection.Take();
  EXPECT_EQ(found.final, nullptr);
  EXPECT_THAT(found.notes,
              ElementsAre("the flight cannot be adjusted with lidar_range_offset among the "
                          "unknowns: the data cannot be fitted"));
}

// Alone, the noise looked like the likeliest effect. With the lever arm in the model, the range
// offset explains the rest better.
TEST(ForwardSelection, ReplacesAnEarlierChoice) {
  KnownFits fits({{{}, {{kNoise, 30.0}, {kArm, 25.0}, {kRange, 20.0}}},
                  {{kNoise}, {{kArm, 20.0}, {kRange, 5.0}}},
                  {{kNoise, kArm}, {{kRange, 1.0}}},
                  {{kArm}, {{kRange, 18.0}, {kNoise, 10.0}}},
                  {{kArm, kRange}, {}}});
  ForwardSelection selection = fits.Select();
  selection.Grow();
  selection.Revise();
  EXPECT_THAT(Names(selection.Take().chosen), ElementsAre("gnss_lever_arm", "lidar_range_offset"));
}

TEST(ForwardSelection, DropsAChoiceThatALaterOneExplains) {
  KnownFits fits({{{}, {{kNoise, 30.0}, {kArm, 25.0}}},
                  {{kNoise}, {{kArm, 20.0}}},
                  {{kNoise, kArm}, {}},
                  {{kArm}, {{kNoise, 2.0}}}});
  ForwardSelection selection = fits.Select();
  selection.Grow();
  selection.Revise();
  const Selection found = selection.Take();
  EXPECT_THAT(Names(found.chosen), ElementsAre("gnss_lever_arm"));
  EXPECT_EQ(found.final->chosen.size(), 1u);
}

TEST(ForwardSelection, ComparesEachChoiceGivenTheOthers) {
  KnownFits fits({{{}, {{kRange, 30.0}, {kArm, 20.0}, {kNoise, 5.0}}},
                  {{kRange}, {{kArm, 12.0}, {kNoise, 3.0}}},
                  {{kArm}, {{kRange, 25.0}, {kNoise, 4.0}}},
                  {{kRange, kArm}, {{kNoise, 1.0}}}});
  ForwardSelection selection = fits.Select();
  selection.Grow();
  selection.Revise();
  const int fitted = fits.count();
  const auto alternatives = selection.Alternatives();
  ASSERT_EQ(alternatives.size(), 2u);
  EXPECT_THAT(Names(alternatives[0]), ElementsAre("lidar_range_offset", "p2p_noise_scale"));
  EXPECT_THAT(Names(alternatives[1]), ElementsAre("gnss_lever_arm", "p2p_noise_scale"));
  EXPECT_EQ(fits.count(), fitted);  // all of these fits were made before
}

TEST(ForwardSelection, FindsNothingInNoise) {
  KnownFits fits({{{}, {{kRange, 1.0}}}});
  ForwardSelection selection = fits.Select();
  selection.Grow();
  selection.Revise();
  EXPECT_THAT(selection.Alternatives(), IsEmpty());
  EXPECT_THAT(selection.Take().chosen, IsEmpty());
}

}  // namespace dn::diagnosis_internal
