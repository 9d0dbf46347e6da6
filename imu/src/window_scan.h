#pragma once

#include <dn/imu/noise_check.h>

#include <array>
#include <optional>
#include <vector>

#include "noise_evidence.h"

namespace dn {

/// A window by the indices of its first cell and of the one after its last.
struct CellSpan {
  std::size_t first = 0;
  std::size_t past = 0;
};

/// Energies of windows by differences of running sums.
class RunningSums {
 public:
  RunningSums(const HighBand& band, ImuTriad triad) : sums_(1) {
    for (const HighBandWindow& window : band.windows) {
      sums_.push_back(sums_.back());
      sums_.back() += window.Of(triad);
    }
  }
  BandEnergy Inside(const CellSpan& span) const {
    return {sums_[span.past].sum - sums_[span.first].sum,
            sums_[span.past].dof - sums_[span.first].dof};
  }
  const BandEnergy& All() const { return sums_.back(); }
  BandEnergy Outside(const BandEnergy& inside) const {
    return {All().sum - inside.sum, All().dof - inside.dof};
  }

 private:
  std::vector<BandEnergy> sums_;
};

/// What the high band says of windows with more noise, whichever they are.
class WindowScan {
 public:
  /// `with_scale`: the noise has its own size outside the window. Windows begin and end on every
  /// `group`-th cell, and near the likeliest of these on any.
  WindowScan(const HighBand& band, const NoiseCheckOptions& options,
             const std::vector<RunningSums>& sums, bool with_scale, std::size_t group);

  double Evidence() const;
  /// Nothing where no window has more noise.
  std::optional<NoiseWindow> Likeliest() const;

 private:
  struct Case {
    double evidence = 0.0;
    double log_likelihood = 0.0;
    std::array<BandEnergy, kImuTriads> inside;  ///< in units of base
    std::array<double, kImuTriads> base{1.0, 1.0};
  };

  struct Seen {
    LogSum sum;
    double weight = 0.0;
    double best = kNever;
    CellSpan likeliest;
  };

  bool IsUsable(ImuTriad triad) const { return sums_[triad].All().dof > 0.0; }
  /// Nothing where too little is left outside to have a size of its own.
  std::optional<Case> CaseOf(const CellSpan& span) const;
  bool AddOutside(const CellSpan& span, ImuTriad triad, Case* one) const;
  static void See(const CellSpan& span, const Case& one, double weight, Seen* seen);
  void SeeAll();
  void SeeNear(const CellSpan& about);
  std::vector<std::size_t> Around(std::size_t edge) const;
  /// Without the first and the last cell, which noise of a window may cover in part.
  Case WithoutEnds(const CellSpan& span, const Case& one) const;
  void AddTriad(const Case& one, ImuTriad triad, NoiseWindow* window) const;

  const HighBand& band_;
  const std::vector<RunningSums>& sums_;
  bool with_scale_;
  std::size_t group_;
  std::size_t reach_;  ///< of the windows near the likeliest, in cells
  RatioPrior prior_;
  std::vector<NoiseLevels> levels_;
  std::vector<Addition> additions_;
  Seen seen_;
};

}  // namespace dn
