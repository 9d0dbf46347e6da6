#pragma once

#include <dn/study/study.h>

namespace dn {

FlightGeometry GeometryOf(const StudyDesign& design);

}  // namespace dn
