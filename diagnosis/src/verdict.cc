#include <dn/diagnosis/diagnosis.h>

namespace dn {

const char* Word(GapVerdictKind kind) {
  switch (kind) {
    case GapVerdictKind::kIdentified:
      return "identified";
    case GapVerdictKind::kGroup:
      return "group";
    case GapVerdictKind::kPartial:
      return "partial";
    case GapVerdictKind::kUnknown:
      return "unknown";
    case GapVerdictKind::kNoGap:
      return "no_gap";
    case GapVerdictKind::kUnavailable:
      return "unavailable";
  }
  return "";
}

}  // namespace dn
