#pragma once

#include <dn/imu/noise_check.h>

#include <array>
#include <optional>
#include <vector>

#include "noise_evidence.h"

namespace dn {

/// Window given by the index of its first cell and the index after its last cell.
struct CellSpan {
  std::size_t first = 0;
  std::size_t past = 0;
};

/// Computes energies of windows from differences of running sums.
class RunningSums {
 public:
  RunningSums(const HighBand& band, ImuTriad triad) : sums_(1) {
    for (const HighBandWindow& window : band.windows) {
      sums_.push_back(sums_.back());
      sums_.back() += window.Total(triad);
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

/// Evaluates additional noise in a window, over all possible windows.
class WindowScan {
 public:
  /// `with_scale`: the noise outside the window has its own level. Windows begin and end at every
  /// `group`-th cell; near the most likely of these they begin and end at any cell.
  WindowScan(const HighBand& band, const NoiseCheckOptions& options,
             const std::vector<RunningSums>& sums, bool with_scale, std::size_t group);

  /// Returns the log evidence, averaged over all windows.
  double Evidence() const;
  /// Returns the most likely window; nullopt if no window has additional noise.
  std::optional<NoiseWindow> Likeliest() const;

 private:
  /// Evidence and energies of one window.
  struct Case {
    double evidence = 0.0;
    double log_likelihood = 0.0;
    std::array<BandEnergy, kImuTriads> inside;  ///< in units of base
    std::array<double, kImuTriads> base{1.0, 1.0};
  };

  /// Sum over the windows evaluated so far, with the most likely one.
  struct Seen {
    LogSum sum;
    double weight = 0.0;
    double best = kLogZero;
    CellSpan likeliest;
  };

  bool IsUsable(ImuTriad triad) const { return sums_[triad].All().dof > 0.0; }
  /// Returns nullopt if too little data outside the window are left to estimate a level.
  std::optional<Case> EvaluateSpan(const CellSpan& span) const;
  // Adds the noise outside the window to the case. Returns false if too little data are outside.
  bool AddOutside(const CellSpan& span, ImuTriad triad, Case* one) const;
  // Adds one case to the sum.
  static void See(const CellSpan& span, const Case& one, double weight, Seen* seen);
  // Evaluates the windows of the coarse grid, then all windows near the most likely one.
  void SeeAll();
  // Evaluates all windows near `about`.
  void SeeNear(const CellSpan& about);
  // Returns the cells near an edge.
  std::vector<std::size_t> Around(std::size_t edge) const;
  /// Returns the case without its first and last cell, which the noise of a window may cover only
  /// in part.
  Case WithoutEnds(const CellSpan& span, const Case& one) const;
  // Sets the sigma of the window for one triad.
  void AddTriad(const Case& one, ImuTriad triad, NoiseWindow* window) const;

  const HighBand& band_;
  const std::vector<RunningSums>& sums_;
  bool with_scale_;
  std::size_t group_;
  std::size_t reach_;  ///< half-width of the fine search around the most likely window, in cells
  RatioPrior prior_;
  std::vector<NoiseLevels> levels_;
  std::vector<Addition> additions_;
  Seen seen_;
};

}  // namespace dn
