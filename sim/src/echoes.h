#pragma once

#include <dn/sim/terrain_caster.h>

#include <array>
#include <cstddef>

namespace dn {

/// Light of a pulse that comes back from one place. The energy is relative to that from a white
/// surface across the beam that fills it.
struct Echo {
  double range_m = 0.0;
  double energy = 0.0;
  Surface surface = Surface::kGround;
};

/// At most so many echoes of a pulse.
inline constexpr std::size_t kBeamParts = 5;

/// Echoes of one pulse.
struct Echoes {
  std::array<Echo, kBeamParts> list;
  std::size_t count = 0;

  void Add(const Echo& echo) { list[count++] = echo; }
};

/// Returns the energy of the echo from a surface that part of the beam meets. Leaves reflect about
/// 0.4 at the usual 1064 or 1550 nm, other surfaces 0.25 to 0.35. Water is a mirror of wavelets
/// whose slopes are normal with a mean square of 0.02 (Cox & Munk, 1954: a light wind).
///
/// part: fraction of the beam.
double EchoEnergy(const RayHit& hit, double part);

/// Returns the LAS class of a surface.
unsigned char PointClass(Surface surface);

/// Returns what the receiver separates. A return begins with an echo. It consists of the echoes
/// within the length of the pulse, and its range is their mean, weighted by energy. Echoes behind
/// it, up to the resolution, are lost. A return that is too weak is not detected, and of the
/// others only the first max_returns are kept.
Echoes Detected(Echoes echoes, double resolution_m, int max_returns);

}  // namespace dn
