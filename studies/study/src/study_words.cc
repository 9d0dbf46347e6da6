#include <dn/adjustment/words.h>
#include <dn/rotation.h>
#include <dn/study/study_output.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace dn {
namespace {

/// Returns "boresight pitch" for "boresight_pitch".
std::string Spoken(std::string name) {
  for (char& c : name) {
    if (c == '_') c = ' ';
  }
  return name;
}

double CourseDeg(const StripGeometry& strip) {
  const double course_rad =
      strip.course_rad < 0.0 ? strip.course_rad + 2.0 * std::numbers::pi : strip.course_rad;
  return std::round(course_rad * kDegPerRad);
}

/// Returns the first unknown of a direction other than the leading one; "" if there is none.
std::string Partner(const StudyDirection& direction) {
  for (const auto& [name, weight] : direction.unknowns) {
    if (name != direction.leading) return Spoken(name);
  }
  return {};
}

std::string CauseText(RemedyKind kind, const StudyResult& study, const StudyDirection& direction) {
  const StripGeometry& strip = study.geometry.strips.front();
  const std::string unknown = Spoken(direction.leading);
  const std::string partner = Partner(direction);
  const std::string alike = partner.empty() ? "errors of the trajectory do" : partner + " does";
  switch (kind) {
    case RemedyKind::kCrossStrip:
      return fmt::format(
          "all strips are parallel (course {:.0f} deg): {} displaces their points in the same way "
          "as {}, and no strip crosses them",
          CourseDeg(strip), unknown, alike);
    case RemedyKind::kOppositeStrip:
      return fmt::format(
          "no strip is flown in the opposite direction: {} displaces the points of all strips to "
          "the same side, and only differences are measured",
          unknown);
    case RemedyKind::kOtherHeight:
      return fmt::format(
          "all strips have one height above ground ({:.0f} m): {} displaces the points in the same "
          "way as {}, and only another height separates a rotation from a shift",
          strip.height_m, unknown, alike);
    case RemedyKind::kOtherSpeed:
      return fmt::format(
          "all strips are flown at one speed ({:.0f} m/s): a delay looks like a shift along the "
          "track",
          strip.speed_mps);
    case RemedyKind::kMorePairs:
      return fmt::format("the noise of the {} pairs of points", study.pairs);
  }
  return {};
}

std::string LimitWords(const StudyResult& study) {
  return fmt::format(
      "the attitude of the trajectory (roll and pitch {:.2g} deg, yaw {:.2g} deg on the strips), "
      "which the pairs of all strips share",
      study.strips.roll_pitch_rad * kDegPerRad, study.strips.yaw_rad * kDegPerRad);
}

std::string PlanWords(RemedyKind kind) {
  switch (kind) {
    case RemedyKind::kCrossStrip:
      return "one more strip across the others, through their middle";
    case RemedyKind::kOppositeStrip:
      return "the first strip once more in the opposite direction";
    case RemedyKind::kOtherHeight:
      return "the first strip once more, its height above ground 40 % greater";
    case RemedyKind::kOtherSpeed:
      return "the first strip once more, 30 % faster";
    case RemedyKind::kMorePairs:
      return "twice as many pairs of points";
  }
  return {};
}

/// Returns what a geometry lacks first, for designs without trials.
std::optional<RemedyKind> Lacking(const FlightGeometry& geometry) {
  if (geometry.parallel) return RemedyKind::kCrossStrip;
  if (geometry.one_direction) return RemedyKind::kOppositeStrip;
  if (geometry.one_height) return RemedyKind::kOtherHeight;
  return std::nullopt;
}

bool IsScenario(const StudyResult& study) { return study.source == DesignSource::kScenario; }

std::optional<RemedyKind> Helpful(const StudyResult& study, const StudyDirection& direction) {
  if (const auto remedy = direction.remedy()) return remedy->kind;
  return IsScenario(study) ? std::nullopt : Lacking(study.geometry);
}

std::string Words(const Unobservable& unobservable) {
  if (unobservable.partner.empty()) {
    return fmt::format(
        "{} has a standard deviation of {:.3g} {}: the flight does not determine it; give it a "
        "prior ({{unknown: .., sigma: ..}}) or leave it out of estimate",
        Spoken(unobservable.unknown), unobservable.value, unobservable.unit);
  }
  return fmt::format(
      "{} and {} cannot be separated (correlation {:.5f}); give one of them a prior, leave it out "
      "of estimate, or vary courses and heights",
      Spoken(unobservable.unknown), Spoken(unobservable.partner), unobservable.value);
}

}  // namespace

std::string CauseWords(const StudyResult& study, const StudyDirection& direction) {
  const auto kind = Helpful(study, direction);
  return kind && !study.geometry.strips.empty() ? CauseText(*kind, study, direction)
                                                : LimitWords(study);
}

std::string RemedyWords(const StudyResult& study, const StudyDirection& direction) {
  const auto kind = Helpful(study, direction);
  if (kind) return PlanWords(*kind) + (IsScenario(study) ? "" : " (not tried)");
  if (direction.tried.empty()) return "a better inertial sensor or more strips (not tried)";
  std::string tried;
  for (const TriedRemedy& remedy : direction.tried) {
    tried += (tried.empty() ? "" : "; ") + PlanWords(remedy.kind);
  }
  return "none of these changes reduces the sigma by 5 % (" + tried +
         "); a better inertial sensor would";
}

std::vector<std::string> UnobservableWords(const StudyResult& study) {
  std::vector<std::string> lines;
  if (study.boresight.verdict == Verdict::kNotObservable) lines = Words(study.boresight.reasons);
  for (std::size_t k = 1; k < study.mountings.scanners.size(); ++k) {
    const ScannerBoresight& scanner = study.mountings.scanners[k];
    if (scanner.boresight.verdict != Verdict::kNotObservable) continue;
    for (const std::string& reason : Words(scanner.boresight.reasons)) {
      lines.push_back("scanner " + scanner.name + ": " + reason);
    }
  }
  for (const Unobservable& unobservable : study.unobservable) lines.push_back(Words(unobservable));
  return lines;
}

}  // namespace dn
