#include <dn/adjustment/stages.h>
#include <dn/error.h>

#include <algorithm>

namespace dn {

std::vector<AdjustmentStage> DefaultStages(bool with_pairs) {
  std::vector<AdjustmentStage> stages{{"network", MakeNetwork},
                                      {"INS/GNSS", SolveInsGnss},
                                      {"GNSS clock", SettleGnssClock},
                                      {"GNSS screening", ScreenGnss}};
  if (with_pairs) {
    stages.push_back({"pairs", AddPairs});
    stages.push_back({"before lidar", AddOwnBeforeLidar});
    stages.push_back({"boresight start", StartBoresight});
    stages.push_back({"lidar, robust", SolvePairsRobustly});
    stages.push_back({"pair rejection", RejectPairs});
    stages.push_back({"control", UseControl});
  }
  stages.push_back({"inertial rate", UseInertialRate});
  stages.push_back({"before final", AddOwnBeforeFinal});
  stages.push_back({"final least squares", SolveFinally});
  return stages;
}

std::vector<AdjustmentStage>::iterator FindStage(const std::string& name,
                                                 std::vector<AdjustmentStage>* stages) {
  const auto found = std::find_if(stages->begin(), stages->end(),
                                  [&](const AdjustmentStage& stage) { return stage.name == name; });
  if (found != stages->end()) return found;
  std::string names;
  for (const AdjustmentStage& stage : *stages)
    names += (names.empty() ? "'" : ", '") + stage.name + "'";
  throw InvalidConfig("adjustment: no stage '" + name + "'; the stages are " + names);
}

void AddOwnBeforeLidar(AdjustmentRun& run) { run.CustomiseBeforeLidar(); }

void AddOwnBeforeFinal(AdjustmentRun& run) { run.Customise(); }

}  // namespace dn
