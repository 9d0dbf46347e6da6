#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "integer_model.h"

namespace dn::lidar_internal::laz {

/// Codes GPS times by the integers that have the same bits.
///
/// Up to four interleaved sequences of times are tracked. A difference is coded as a multiple of an
/// earlier difference of its sequence, plus a correction. A time far from all sequences replaces
/// the oldest one. kRepeats says whether a time can equal the one before: in version 2 of the item
/// GPSTIME11. POINT14 has a flag for that case, so its symbols lack it.
template <bool kRepeats>
class GpsTimes {
 public:
  explicit GpsTimes(std::int64_t first = 0) { times_[0] = first; }

  /// Codes a time; see Decoder.
  template <class Coder>
  std::int64_t Code(Coder& coder, std::int64_t time) {
    bool done = false;
    while (!done) {
      done = differences_[current_] == 0 ? CodeFirst(coder, &time) : CodeMultiple(coder, &time);
    }
    return time;
  }

 private:
  static constexpr std::size_t kSequences = 4;
  static constexpr std::uint32_t kShift = kRepeats ? 1 : 0;
  // These symbols follow a difference of zero. A switch by i sequences is kNewFirst + i.
  static constexpr std::uint32_t kSmallFirst = kShift, kNewFirst = kShift + 1;
  // These symbols are multiples: 0 to 500, then -1 to -10. A switch by i sequences is kNew + i.
  static constexpr std::uint32_t kMost = 500, kLeast = 510, kRepeat = 511, kNew = 511 + kShift;
  static constexpr int kPatience = 3;  // number of extreme multiples without a new difference

  /// Codes a time after a difference of zero. Returns false if only the sequence was switched.
  template <class Coder>
  bool CodeFirst(Coder& coder, std::int64_t* time) {
    std::uint32_t symbol = 0;
    if constexpr (Coder::kWrites) symbol = ChooseFirst(*time);
    symbol = coder.Symbol(first_, symbol);
    if (kRepeats && symbol == 0) {
      *time = times_[current_];
    } else if (symbol == kSmallFirst) {
      differences_[current_] = CodeDifference(coder, 0, 0, time);
      extremes_[current_] = 0;
    } else if (symbol == kNewFirst) {
      StartSequence(coder, time);
    } else {
      current_ = (current_ + symbol - kNewFirst) % kSequences;
      return false;
    }
    return true;
  }

  /// Codes a time after a difference other than zero. Returns false if only the sequence was
  /// switched.
  template <class Coder>
  bool CodeMultiple(Coder& coder, std::int64_t* time) {
    std::uint32_t symbol = 0;
    if constexpr (Coder::kWrites) symbol = ChooseMultiple(*time);
    symbol = coder.Symbol(multiple_, symbol);
    if (symbol <= kLeast) {
      CodeWithMultiple(coder, symbol, time);
    } else if (kRepeats && symbol == kRepeat) {
      *time = times_[current_];
    } else if (symbol == kNew) {
      StartSequence(coder, time);
    } else {
      current_ = (current_ + symbol - kNew) % kSequences;
      return false;
    }
    return true;
  }

  template <class Coder>
  void CodeWithMultiple(Coder& coder, std::uint32_t symbol, std::int64_t* time) {
    const std::uint32_t multiple = symbol <= kMost ? symbol : kMost - symbol;
    const std::uint32_t predicted = multiple * static_cast<std::uint32_t>(differences_[current_]);
    const std::int32_t difference =
        CodeDifference(coder, static_cast<std::int32_t>(predicted), Context(symbol), time);
    int& extremes = extremes_[current_];
    if (symbol == 1) extremes = 0;
    if (symbol != 0 && symbol != kMost && symbol != kLeast) return;
    if (++extremes <= kPatience) return;
    differences_[current_] = difference;
    extremes = 0;
  }

  static std::size_t Context(std::uint32_t symbol) {
    if (symbol == 0) return 7;
    if (symbol == 1) return 1;
    if (symbol < 10) return 2;
    if (symbol < kMost) return 3;
    if (symbol == kMost) return 4;
    return symbol < kLeast ? 5 : 6;
  }

  template <class Coder>
  std::int32_t CodeDifference(Coder& coder, std::int32_t predicted, std::size_t context,
                              std::int64_t* time) {
    const std::int32_t difference = corrections_.Code(
        coder, predicted, static_cast<std::int32_t>(Since(current_, *time)), context);
    times_[current_] = Sum(times_[current_], difference);
    *time = times_[current_];
    return difference;
  }

  template <class Coder>
  void StartSequence(Coder& coder, std::int64_t* time) {
    const auto upper = static_cast<std::int32_t>(times_[current_] >> 32);
    const std::int64_t high =
        corrections_.Code(coder, upper, static_cast<std::int32_t>(*time >> 32), 8);
    const std::uint32_t low = CodeRaw32(coder, static_cast<std::uint32_t>(*time));
    newest_ = (newest_ + 1) % kSequences;
    current_ = newest_;
    *time = static_cast<std::int64_t>(static_cast<std::uint64_t>(high) << 32 | low);
    times_[current_] = *time;
    differences_[current_] = 0;
    extremes_[current_] = 0;
  }

  static std::int64_t Sum(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
  }

  std::int64_t Since(std::size_t sequence, std::int64_t time) const {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(time) -
                                     static_cast<std::uint64_t>(times_[sequence]));
  }

  bool IsClose(std::size_t sequence, std::int64_t time) const {
    const std::int64_t since = Since(sequence, time);
    return since == static_cast<std::int32_t>(since);
  }

  /// Returns the number of sequences to the next one that is close to a time; 0 if there is none.
  std::uint32_t Switch(std::int64_t time) const {
    for (std::uint32_t i = 1; i < kSequences; ++i) {
      if (IsClose((current_ + i) % kSequences, time)) return i;
    }
    return 0;
  }

  std::uint32_t ChooseFirst(std::int64_t time) const {
    if (kRepeats && time == times_[current_]) return 0;
    return IsClose(current_, time) ? kSmallFirst : kNewFirst + Switch(time);
  }

  std::uint32_t ChooseMultiple(std::int64_t time) const {
    if (kRepeats && time == times_[current_]) return kRepeat;
    if (!IsClose(current_, time)) return kNew + Switch(time);
    const auto difference = static_cast<float>(Since(current_, time));
    const float ratio = std::clamp(difference / static_cast<float>(differences_[current_]),
                                   static_cast<float>(kMost) - static_cast<float>(kLeast),
                                   static_cast<float>(kMost));
    const auto multiple = static_cast<std::int32_t>(std::lround(ratio));
    return static_cast<std::uint32_t>(multiple >= 0 ? multiple
                                                    : static_cast<std::int32_t>(kMost) - multiple);
  }

  SymbolModel first_{5 + kShift};
  SymbolModel multiple_{515 + kShift};
  IntegerModel<32> corrections_{9};
  std::size_t current_ = 0, newest_ = 0;
  std::array<std::int64_t, kSequences> times_{};
  std::array<std::int32_t, kSequences> differences_{};
  std::array<int, kSequences> extremes_{};
};

}  // namespace dn::lidar_internal::laz
