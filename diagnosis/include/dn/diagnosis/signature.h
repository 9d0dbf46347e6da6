#pragma once

#include <dn/flight/flight.h>
#include <dn/gap/diagnose.h>

#include <string>

namespace dn {

/// How a departure from the model would show if there were no noise.
struct Signature {
  /// Noncentrality: by how much twice the cost of the best fit grows by the departure. The square of
  /// the number of sigmas that the best of all tests would see.
  double lambda = 0.0;
  /// What is left of it with the nearest effect among the unknowns: what no single fixed effect of
  /// the library can take the place of, to first order.
  double lambda_left = 0.0;
  std::string nearest;  ///< that effect; empty where none takes any part
};

/// Of a departure that `with` holds and `without` does not, both simulated without noise and otherwise
/// the same, read with their assumed model. All data are used: nothing counts as a gross error. Of
/// the options, effects, left_out, threads and `interrupted` count. Throws as Adjust, RankDeficient
/// where an unknown is free, InvalidConfig for bad options.
Signature SignatureOf(const Flight& with, const Flight& without, const GapOptions& options = {});

}  // namespace dn
