#include <dn/adjustment/swath_separation.h>

#include <cmath>

namespace dn {
namespace {

constexpr std::array<double, 5> kLimits_m{0.03, 0.05, 0.08, 0.10, 0.16};

}  // namespace

void SwathSeparation::Add(double up_m) {
  ++pairs_;
  for (std::size_t k = 0; k < kLimits_m.size(); ++k) {
    if (std::abs(up_m) <= kLimits_m[k]) ++within_[k];
  }
}

Json SwathSeparation::ToJson() const {
  const auto share = [this](long pairs) {
    return static_cast<double>(pairs) / static_cast<double>(pairs_);
  };
  return {{"to_8_cm", share(within_[2])},
          {"8_to_16_cm", share(within_[4] - within_[2])},
          {"above_16_cm", share(pairs_ - within_[4])},
          {"within_3_cm", share(within_[0])},
          {"within_5_cm", share(within_[1])},
          {"within_10_cm", share(within_[3])}};
}

}  // namespace dn
