#pragma once

#include <string>

#include "screen.h"

namespace dn::internal {

/// Gross errors: of `of_all` measurements `found` were left out, where good data lose the share
/// `usual`. Log evidence by Poisson's distribution, the expected number likely of any size.
ScreenedEffect OutlierEffect(const std::string& name, long found, long of_all, double usual,
                             double size_m);

}  // namespace dn::internal
