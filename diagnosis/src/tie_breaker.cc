#include "tie_breaker.h"

#include <dn/diagnosis/replicate_scenario.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/geo/nearest_pose.h>
#include <dn/interrupted.h>
#include <dn/parallel.h>
#include <dn/rotation.h>
#include <dn/sim/extra_lines.h>
#include <dn/sim/simulate.h>
#include <dn/solvers/marginals.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "design_limits.h"
#include "effect_words.h"
#include "simulated_replicates.h"

namespace dn::diagnosis_internal {
namespace {

// Noncentrality at which the data favour the right effect by 19 to 1 with probability 0.8. The
// evidence in nats has the mean kSeparated / 2 and the standard deviation sqrt(kSeparated); the
// mean minus 0.84 standard deviations is ln 19.
constexpr double kSeparated = 11.6;
constexpr double kSlowestMps = 0.5;

bool IsConstantEffect(const GapCause& cause) {
  const EffectSpec* spec = FindEffect(cause.effect);
  return spec != nullptr && spec->kind == EffectKind::kFixed && !cause.times.window_s &&
         !cause.times.t0_s;
}

const GapCause* Find(const GapDiagnosis& diagnosis, const std::string& effect) {
  const auto at = std::find_if(diagnosis.causes.begin(), diagnosis.causes.end(),
                               [&](const GapCause& cause) { return cause.effect == effect; });
  return at == diagnosis.causes.end() ? nullptr : &*at;
}

const Hypothesis* FindHypothesis(const Screen& screen, const std::string& effect) {
  for (const EffectFamily& family : screen.families()) {
    if (family.name == effect) return &screen.library().hypotheses[family.first];
  }
  return nullptr;
}

/// Returns the strips of the flight as planned lines.
std::vector<PlannedLine> PlannedStripLines(const Flight& flight, const Trajectory& estimated) {
  const std::vector<MapPose> poses = estimated.ToMapPoses(flight.frame);
  std::vector<PlannedLine> lines;
  for (const StripInterval& strip : FindStrips(flight)) {
    const Eigen::Vector3d start_m = NearestPose(poses, strip.t0_s).p_mb;
    const Eigen::Vector3d end_m = NearestPose(poses, strip.t1_s).p_mb;
    PlannedLine line;
    line.start_en_m = start_m.head<2>();
    line.end_en_m = end_m.head<2>();
    line.height_m = 0.5 * (start_m.z() + end_m.z());
    line.speed_mps =
        (line.end_en_m - line.start_en_m).norm() / std::max(strip.t1_s - strip.t0_s, 1e-3);
    if (line.speed_mps > kSlowestMps) lines.push_back(line);
  }
  return lines;
}

/// Returns the rms attitude motion on the strips relative to straight flight.
TurbulenceScenario AttitudeMotion(const Flight& flight, const Trajectory& estimated) {
  const std::vector<MapPose> poses = estimated.ToMapPoses(flight.frame);
  Eigen::Vector3d sum2 = Eigen::Vector3d::Zero();
  long n = 0;
  for (const StripInterval& strip : FindStrips(flight)) {
    std::vector<Eigen::Vector3d> turns;
    const Eigen::Quaterniond middle = NearestPose(poses, 0.5 * (strip.t0_s + strip.t1_s)).q_mb;
    for (const MapPose& pose : poses) {
      if (pose.t_s < strip.t0_s || pose.t_s > strip.t1_s) continue;
      turns.push_back(Log(Eigen::Quaterniond(middle.conjugate() * pose.q_mb)));
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& turn : turns) mean += turn / static_cast<double>(turns.size());
    for (const Eigen::Vector3d& turn : turns) sum2 += (turn - mean).cwiseAbs2();
    n += static_cast<long>(turns.size());
  }
  TurbulenceScenario motion;
  if (n == 0) return motion;
  const Eigen::Vector3d rms = (sum2 / static_cast<double>(n)).cwiseSqrt();
  motion.roll_rad = rms.x();
  motion.pitch_rad = rms.y();
  motion.heading_rad = rms.z();
  return motion;
}

Scenario MakePlan(const Flight& flight, const Trajectory& estimated,
                  const Eigen::Vector3d& boresight_rad) {
  Scenario scenario = MakeReplicateScenario(flight, estimated, {}, boresight_rad);
  scenario.plan.replay.reset();
  scenario.plan.strips.clear();
  scenario.plan.lines = PlannedStripLines(flight, estimated);
  scenario.plan.turbulence = AttitudeMotion(flight, estimated);
  const std::vector<StripInterval> strips = FindStrips(flight);
  if (!strips.empty()) {
    scenario.plan.warm_up_s = std::max(0.0, strips.front().t0_s - estimated.t_begin_s());
  }
  std::erase_if(scenario.effects, [](const Effect& effect) { return effect.times.window_s; });
  return scenario;
}

struct Attempt {
  std::string strip;  ///< "across the others"
  Scenario scenario;
};

std::vector<Attempt> MakeAttempts(const Scenario& plan) {
  std::vector<Attempt> attempts;
  if (plan.plan.lines.empty()) return attempts;
  const PlannedLine& first = plan.plan.lines.front();
  const auto add = [&](const std::string& strip, const PlannedLine& line) {
    attempts.push_back({strip, plan});
    Scenario& scenario = attempts.back().scenario;
    const auto before = static_cast<long>(scenario.plan.lines.size());
    scenario.plan.lines.push_back(line);
    scenario.pairs.count += scenario.pairs.count / before;
  };
  const double height_m = first.height_m - plan.terrain.base_m;
  add("across the others", CrossLine(plan.plan.lines));
  add("along the first one in the opposite direction", Reversed(first));
  add("along the first one 40 % higher above ground", Higher(first, height_m));
  add("along the first one 30 % faster", Faster(first));
  return attempts;
}

/// Returns the separation from each competing effect. Returns {} if the plan cannot be flown or
/// leaves an unknown free.
std::vector<double> ComputeSeparations(const Scenario& scenario, const Flight& flight,
                                       const Tie& tie, const GapOptions& options) {
  SimulateOptions simulate;
  simulate.noise = false;
  GapOptions alone;
  alone.effects = tie.competing_effects;
  alone.effects.push_back(tie.named.effect);
  alone.threads = 1;
  try {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    Flight planned = Simulate(scenario, simulate).flight;
    CopyAssumptions(flight.config, &planned.config);
    planned.config.imu->model.vibration.clear();  // its windows are those of the flight
    const Screen screen = ScreenDesign(planned, alone);
    std::vector<double> separations;
    for (const std::string& other : tie.competing_effects) {
      separations.push_back(Separation(screen, tie.named, other));
    }
    return separations;
  } catch (const InvalidConfig&) {
  } catch (const InvalidInput&) {
  } catch (const RankDeficient&) {
  }
  return {};
}

std::vector<std::string> SeparatedEffects(const Tie& tie, const std::vector<double>& separations) {
  std::vector<std::string> separated;
  for (std::size_t k = 0; k < separations.size(); ++k) {
    if (separations[k] > kSeparated) separated.push_back(tie.competing_effects[k]);
  }
  return separated;
}

double Least(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::min_element(values.begin(), values.end());
}

}  // namespace

std::vector<Tie> FindTies(const GapDiagnosis& diagnosis) {
  std::vector<Tie> ties;
  for (const std::string& effect : diagnosis.verdict.effects) {
    const GapCause* named = Find(diagnosis, effect);
    if (named == nullptr || !IsConstantEffect(*named)) continue;
    Tie tie{*named, {}};
    for (const std::string& name : named->inseparable_from) {
      const GapCause* other = Find(diagnosis, name);
      if (other != nullptr && IsConstantEffect(*other)) tie.competing_effects.push_back(name);
    }
    if (!tie.competing_effects.empty()) ties.push_back(std::move(tie));
  }
  return ties;
}

double Separation(const Screen& screen, const GapCause& named, const std::string& other) {
  const Hypothesis* of_named = FindHypothesis(screen, named.effect);
  const Hypothesis* of_other = FindHypothesis(screen, other);
  if (of_named == nullptr || of_other == nullptr) return std::numeric_limits<double>::infinity();
  const JointScore& score = screen.score();
  const Eigen::VectorXd size = named.estimate / of_named->per_si;
  const double alone = size.dot(SelectInformation(*of_named, score) * size);
  const Eigen::VectorXd shared = SelectInformation(*of_other, *of_named, score) * size;
  const ScoreTest taken_up =
      TestScore(shared, SelectInformation(*of_other, score), SelectSignature(*of_other, score));
  return alone - taken_up.statistic;
}

std::string ProposeTieBreaker(const Flight& flight, const Trajectory& estimated,
                              const Eigen::Vector3d& boresight_rad, const Tie& tie,
                              const GapOptions& options) {
  if (!flight.pairs || flight.pairs->pairs.empty()) return "";
  const std::vector<Attempt> attempts = MakeAttempts(MakePlan(flight, estimated, boresight_rad));
  std::vector<std::vector<double>> separations(attempts.size());
  ParallelFor(static_cast<int>(attempts.size()), options.threads, [&](int k) {
    const auto at = static_cast<std::size_t>(k);
    separations[at] = ComputeSeparations(attempts[at].scenario, flight, tie, options);
  });
  std::optional<std::size_t> best;
  std::vector<std::string> separated;
  for (std::size_t k = 0; k < attempts.size(); ++k) {
    const std::vector<std::string> here = SeparatedEffects(tie, separations[k]);
    const bool more =
        here.size() > separated.size() || (best && here.size() == separated.size() &&
                                           Least(separations[k]) > 2.0 * Least(separations[*best]));
    if (here.empty() || !more) continue;
    best = k;
    separated = here;
  }
  if (!best) return "";
  return "one more strip " + attempts[*best].strip + " would separate " + tie.named.effect +
         " from " + Alternatives(separated);
}

}  // namespace dn::diagnosis_internal
