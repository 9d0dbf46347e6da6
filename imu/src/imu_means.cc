#include <dn/imu/imu_means.h>

#include <algorithm>
#include <limits>

#include "bridge_cursor.h"

namespace dn {
namespace {

class Joiner {
 public:
  Joiner(const ImuData& imu, double longest_s)
      : imu_(imu),
        longest_s_(longest_s * (1.0 + 1e-9)),
        bridges_(imu, std::numeric_limits<double>::lowest()) {}

  std::vector<ImuSample> Run() {
    for (const ImuSample& sample : imu_.samples) {
      const bool bridges = bridges_.Find(sample) != nullptr;
      if (bridges || closed_ || !Fits(sample)) {
        joined_.push_back(sample);
      } else {
        Join(sample, &joined_.back());
      }
      closed_ = bridges;
    }
    return std::move(joined_);
  }

 private:
  bool Fits(const ImuSample& sample) const {
    return Adjoin(joined_.back(), sample) && joined_.back().dt_s + sample.dt_s <= longest_s_;
  }

  static void Join(const ImuSample& sample, ImuSample* mean) {
    const double dt_s = sample.t_s - (mean->t_s - mean->dt_s);
    const double share = sample.dt_s / dt_s;
    mean->w_ib_b_radps += share * (sample.w_ib_b_radps - mean->w_ib_b_radps);
    mean->f_b_mps2 += share * (sample.f_b_mps2 - mean->f_b_mps2);
    mean->t_s = sample.t_s;
    mean->dt_s = dt_s;
  }

  const ImuData& imu_;
  double longest_s_;
  imu_internal::BridgeCursor bridges_;
  std::vector<ImuSample> joined_;
  bool closed_ = true;  // true if no other sample may be joined to the last one
};

}  // namespace

ImuData AverageSamples(const ImuData& imu, double longest_s) {
  ImuData means;
  means.samples = Joiner(imu, longest_s).Run();
  means.nominal_dt_s = std::max(imu.nominal_dt_s, longest_s);
  means.uneven = imu.uneven;
  means.gaps = imu.gaps;
  means.bridges = imu.bridges;
  return means;
}

}  // namespace dn
