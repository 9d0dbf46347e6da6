#include <dn/diagnosis/solution.h>

#include <utility>

namespace dn {

Solution::Solution(const Flight& flight, const AdjustOptions& options)
    : Solution(Adjust(flight, options), options.threads) {}

Solution::Solution(Adjustment adjustment, int threads)
    : adjustment_(std::move(adjustment)),
      threads_(threads),
      marginals_(adjustment_.network->net(),
                 {.threads = threads, .analysis = std::move(adjustment_.analysis)}) {
  marginals_.ComputeSelectedInverse();
}

const TrajectoryResult& Solution::trajectory() const {
  if (!trajectory_) trajectory_ = ExtractTrajectory(adjustment_, marginals_);
  return *trajectory_;
}

const ModelCheck& Solution::model_check() const {
  if (!model_check_) model_check_ = CheckModel(adjustment_, marginals_, trajectory(), threads_);
  return *model_check_;
}

BoresightResult Solution::Boresight() const { return ExtractBoresight(adjustment_, marginals_); }

BoresightResult Solution::CheckedBoresight() const {
  BoresightResult boresight = Boresight();
  Assess(model_check(), &boresight);
  return boresight;
}

std::vector<UnknownEstimate> Solution::Unknowns() const {
  return ExtractUnknowns(adjustment_, marginals_);
}

TrajectoryCovariance Solution::PoseCovariance(const std::vector<StripInterval>& strips) const {
  return ExtractTrajectoryCovariance(adjustment_, marginals_, strips);
}

}  // namespace dn
