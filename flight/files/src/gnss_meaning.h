#pragma once

#include <string>
#include <vector>

#include "column_meaning.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Returns a name that FindMeaning understands: "gpsLatitude" becomes "gps latitude", "hEllM"
/// becomes "h ell (m)", "lat_deg" becomes "lat (deg)".
std::string SpelledName(const std::string& name);

/// Returns the sample with spelled names.
TextSample WithSpelledNames(const TextSample& sample);

/// Returns the meanings of the columns of a file of GNSS positions with spelled names. Beside the
/// names of FindMeaning there are sigma_en, var_e, var_n, var_u, lat_ns, lon_ew, and `accuracy` for
/// an accuracy of another kind.
std::vector<ColumnMeaning> FindGnssMeanings(const TextSample& spelled);

}  // namespace dn::files_internal
