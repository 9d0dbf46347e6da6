#pragma once

#include <dn/study/study.h>

namespace dn {

/// Returns the properties that the strips of a design have in common.
FlightGeometry ComputeGeometry(const StudyDesign& design);

}  // namespace dn
