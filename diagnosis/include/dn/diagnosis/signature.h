#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/files/flight.h>

#include <string>

namespace dn {

/// Noise-free signature of an unmodelled discrepancy.
struct Signature {
  /// Noncentrality: increase of twice the cost of the best fit caused by the discrepancy. It is the
  /// squared number of sigmas seen by the most powerful test.
  double lambda = 0.0;
  /// Noncentrality that remains once the nearest single fixed effect of the library is among the
  /// unknowns, to first order.
  double lambda_left = 0.0;
  std::string nearest;  ///< name of that effect; empty if no effect absorbs any part
};

/// Computes the signature of a discrepancy that `with` contains and `without` does not. Both
/// flights are simulated without noise, are otherwise equal, and are adjusted with their assumed
/// model. All data are used: no outlier is rejected. Of the options, only `effects`, `left_out`,
/// `threads` and `interrupted` are used. Throws as Adjust, RankDeficient if an unknown is not
/// determined, and InvalidConfig for invalid options.
Signature ComputeSignature(const Flight& with, const Flight& without,
                           const GapOptions& options = {});

}  // namespace dn
