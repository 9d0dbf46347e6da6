#include <dn/files/scanners.h>

#include <utility>

#include "effects.h"

namespace dn {
namespace {

/// An effect of one of several scanners.
class ScannerEffect final : public LidarEffect {
 public:
  ScannerEffect(std::shared_ptr<const LidarEffect> effect, int scanner)
      : effect_(std::move(effect)), scanner_(scanner) {}

  int components() const override { return effect_->components(); }
  bool moves_epochs() const override { return effect_->moves_epochs(); }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    if (reading->scanner == scanner_) effect_->Correct(value, column, reading);
  }

 private:
  std::shared_ptr<const LidarEffect> effect_;
  int scanner_;
};

}  // namespace

EffectAction OnScanner(EffectAction action, std::size_t scanner) {
  const auto* lidar = std::get_if<std::shared_ptr<const LidarEffect>>(&action);
  if (lidar == nullptr) return action;
  return std::make_shared<const ScannerEffect>(*lidar, static_cast<int>(scanner));
}

EffectAction MakeAction(const EstimableEffect& effect, const EffectSite& site) {
  EffectAction action = effect.make(site);
  if (NumScanners(site.flight.config) < 2) return action;
  return OnScanner(std::move(action), site.scanner);
}

}  // namespace dn
