#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/parallel.h>
#include <dn/sim/simulate.h>
#include <dn/study/line_choice.h>
#include <dn/study/study_output.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>

namespace dn {
namespace {

using Lines = std::uint32_t;  ///< one bit per line

std::vector<std::size_t> LineIndices(Lines lines) {
  std::vector<std::size_t> indices;
  for (std::size_t k = 0; lines >> k != 0; ++k) {
    if ((lines >> k & 1u) != 0) indices.push_back(k);
  }
  return indices;
}

bool IsSubset(Lines some, Lines all) { return (some & ~all) == 0; }

class Search {
 public:
  Search(const LineCandidates& candidates, const LineSearchOptions& options)
      : candidates_(candidates),
        options_(options),
        all_((Lines{1} << candidates.names.size()) - 1u) {}

  LineSearch Run() {
    Study({all_});
    if (Meets(all_)) {
      Lines best = ShortenOneByOne();
      best = FirstThatMeets(ShorterThan(best), best);
      return Result(best);
    }
    return Result(0);
  }

 private:
  /// Number of choices studied in parallel. It is constant because the choices that are studied
  /// must not depend on the number of threads.
  static constexpr std::size_t kAtOnce = 8;

  bool Meets(Lines lines) const {
    return studied_.at(lines).WorstRatio(candidates_.target_rad) <= 1.0;
  }

  /// Leaves out the line that saves the most time, as long as the target is met.
  Lines ShortenOneByOne() {
    Lines best = all_;
    for (bool shorter = true; shorter;) {
      shorter = false;
      std::vector<Lines> less;
      for (const std::size_t k : LineIndices(best)) less.push_back(best & ~(Lines{1} << k));
      std::erase_if(less, [](Lines lines) { return LineIndices(lines).size() < 2; });
      Study(less);
      for (const Lines lines : less) {
        if (!Meets(lines) || !IsShorter(lines, best)) continue;
        best = lines;
        shorter = true;
      }
    }
    return best;
  }

  bool IsShorter(Lines a, Lines b) { return FlightTime(a) < FlightTime(b); }

  std::vector<Lines> ShorterThan(Lines best) {
    std::vector<Lines> shorter;
    for (Lines lines = 1; lines <= all_; ++lines) {
      if (LineIndices(lines).size() >= 2 && IsShorter(lines, best)) shorter.push_back(lines);
    }
    std::stable_sort(shorter.begin(), shorter.end(),
                     [&](Lines a, Lines b) { return IsShorter(a, b); });
    return shorter;
  }

  /// Returns the first choice of `by_time` that meets the target, or `otherwise` if there is none.
  Lines FirstThatMeets(std::vector<Lines> by_time, Lines otherwise) {
    while (!by_time.empty()) {
      std::erase_if(by_time, [&](Lines lines) { return MissesWithMoreLines(lines); });
      const std::size_t n = std::min(kAtOnce, by_time.size());
      const std::vector<Lines> next(by_time.begin(),
                                    by_time.begin() + static_cast<std::ptrdiff_t>(n));
      Study(next);
      for (const Lines lines : next) {
        if (Meets(lines)) return lines;
      }
    }
    return otherwise;
  }

  bool MissesWithMoreLines(Lines lines) const {
    return std::any_of(studied_.begin(), studied_.end(), [&](const auto& one) {
      return IsSubset(lines, one.first) && !Meets(one.first);
    });
  }

  double FlightTime(Lines lines) {
    const auto known = times_s_.find(lines);
    if (known != times_s_.end()) return known->second;
    if (options_.design.interrupted && options_.design.interrupted()) throw Interrupted();
    const FlightTimes times =
        PlannedTimes(candidates_.With(LineIndices(lines)), options_.design.seed);
    return times_s_[lines] = times.end_s - times.begin_s;
  }

  void Study(std::vector<Lines> choices) {
    std::erase_if(choices, [&](Lines lines) { return studied_.contains(lines); });
    std::vector<LineChoice> results(choices.size());
    for (std::size_t k = 0; k < choices.size(); ++k) {
      results[k].lines = LineIndices(choices[k]);
      results[k].flight_time_s = FlightTime(choices[k]);
    }
    ParallelFor(static_cast<int>(choices.size()), options_.design.threads,
                [&](int k) { StudyOne(&results[static_cast<std::size_t>(k)]); });
    for (std::size_t k = 0; k < choices.size(); ++k) studied_[choices[k]] = std::move(results[k]);
    if (options_.progress) options_.progress(studied_.size());
  }

  void StudyOne(LineChoice* choice) const {
    StudyOptions study{options_.design, false};
    study.design.threads = 1;
    study.design.estimate = candidates_.estimate;
    try {
      const StudyResult result = dn::Study(candidates_.With(choice->lines), study);
      if (result.observable()) {
        choice->sigma_rad = result.boresight.sigma_rad();
      } else {
        choice->failure = UnobservableWords(result).front();
      }
    } catch (const RankDeficient& error) {
      choice->failure = error.what();
    }
  }

  LineSearch Result(Lines best) {
    LineSearch search;
    for (auto& [lines, choice] : studied_) search.studied.push_back(choice);
    std::stable_sort(
        search.studied.begin(), search.studied.end(),
        [](const LineChoice& a, const LineChoice& b) { return a.flight_time_s < b.flight_time_s; });
    const auto at =
        std::find_if(search.studied.begin(), search.studied.end(),
                     [&](const LineChoice& choice) { return choice.lines == LineIndices(best); });
    if (at != search.studied.end()) search.best = at - search.studied.begin();
    return search;
  }

  const LineCandidates& candidates_;
  const LineSearchOptions& options_;
  Lines all_;
  std::map<Lines, LineChoice> studied_;
  std::map<Lines, double> times_s_;
};

}  // namespace

double LineChoice::WorstRatio(const Eigen::Vector3d& target_rad) const {
  if (!failure.empty()) return std::numeric_limits<double>::infinity();
  return sigma_rad.cwiseQuotient(target_rad).maxCoeff();
}

LineSearch ChooseLines(const LineCandidates& candidates, const LineSearchOptions& options) {
  return Search(candidates, options).Run();
}

}  // namespace dn
