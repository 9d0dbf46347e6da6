#pragma once

#include <array>
#include <string>

namespace paper {

/// Published figures of the paper for one strip set: Table 1 (attitude of the trajectory) and the
/// table of the Gauss-Helmert adjustment.
struct PublishedSet {
  const char* name;
  double sigma_rp_deg, sigma_y_deg;
  double condition_number, sigma0, residual_initial_m, residual_final_m;
};

/// The figures of the two-line sets of LAR and UAV are listed for both pairs of lines, parallel and
/// crossing.
inline constexpr std::array<PublishedSet, 12> kPublished{{
    {"leg2", .005, .010, 26, .9, .87, .15},
    {"leg4", .005, .010, 48, 1.1, 1.03, .14},
    {"lar2", .002, .005, 13, .5, 1.28, .04},
    {"lar2_cross", .002, .005, 13, .5, 1.28, .04},
    {"lar3", .002, .005, 21, .4, 1.27, .06},
    {"uav2", .025, .080, 15, .3, 1.25, .07},
    {"uav2_cross", .025, .080, 15, .3, 1.25, .07},
    {"uav3", .025, .080, 28, .5, 1.25, .14},
    {"har2", .0025, .005, 926, .9, 6.80, .15},
    {"har4", .0025, .005, 40, .8, 12.19, .18},
    {"hal2", .005, .008, 24, .4, 5.07, .14},
    {"hal4", .005, .008, 15, .6, 5.99, .20},
}};

/// Returns the figures of a set. Throws std::invalid_argument for an unknown name.
const PublishedSet& Published(const std::string& name);

}  // namespace paper
