#pragma once

#include <dn/geo/little_endian.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "gps_times.h"
#include "items.h"

namespace dn::lidar_internal::laz {

/// Item GPSTIME11, version 2.
template <class Coder>
class PointTimes final : public PointItem<Coder> {
 public:
  void Start(const char* first) override {
    times_ = GpsTimes<true>(LoadLittleEndian<std::int64_t>(first));
  }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    std::int64_t time = 0;
    if constexpr (Coder::kWrites) time = LoadLittleEndian<std::int64_t>(part);
    time = times_.Code(coder, time);
    if constexpr (!Coder::kWrites) StoreLittleEndian(time, part);
  }

 private:
  GpsTimes<true> times_;
};

/// Item GPSTIME11, version 1.
template <class Coder>
class OldPointTimes final : public PointItem<Coder> {
 public:
  void Start(const char* first) override { last_ = LoadLittleEndian<std::int64_t>(first); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    std::int64_t time = last_;
    if constexpr (Coder::kWrites) time = LoadLittleEndian<std::int64_t>(part);
    if (difference_ == 0) {
      CodeFirst(coder, &time);
    } else {
      CodeMultiple(coder, &time);
    }
    if constexpr (!Coder::kWrites) StoreLittleEndian(time, part);
    last_ = time;
  }

 private:
  static constexpr std::uint32_t kRepeat = 511, kNew = 510, kMost = 509;
  static constexpr int kPatience = 3;  // number of extreme multiples without a new difference

  static std::uint64_t Unsigned(std::int64_t value) { return static_cast<std::uint64_t>(value); }

  std::int64_t Since(std::int64_t time) const {
    return static_cast<std::int64_t>(Unsigned(time) - Unsigned(last_));
  }

  bool IsClose(std::int64_t time) const {
    return Since(time) == static_cast<std::int32_t>(Since(time));
  }

  void CodeFirst(Coder& coder, std::int64_t* time) {
    std::uint32_t symbol = 0;
    if constexpr (Coder::kWrites) symbol = *time == last_ ? 0 : IsClose(*time) ? 1 : 2;
    symbol = coder.Symbol(first_, symbol);
    if (symbol == 1) difference_ = CodeDifference(coder, 0, 0, time);
    if (symbol == 2) *time = static_cast<std::int64_t>(CodeRaw64(coder, Unsigned(*time)));
  }

  void CodeMultiple(Coder& coder, std::int64_t* time) {
    std::uint32_t symbol = 0;
    if constexpr (Coder::kWrites) symbol = Choose(*time);
    symbol = coder.Symbol(multiple_, symbol);
    if (symbol == kNew) *time = static_cast<std::int64_t>(CodeRaw64(coder, Unsigned(*time)));
    if (symbol > kMost) return;
    const auto predicted =
        static_cast<std::int32_t>(symbol * static_cast<std::uint32_t>(difference_));
    const std::int32_t difference =
        CodeDifference(coder, symbol == 0 ? difference_ / 4 : predicted, Context(symbol), time);
    if (symbol == 0 || symbol == kMost) ++extremes_;
    if (symbol != 1 && extremes_ <= kPatience) return;
    difference_ = difference;
    extremes_ = 0;
  }

  static std::size_t Context(std::uint32_t symbol) {
    if (symbol == 0) return 2;
    if (symbol == 1) return 1;
    if (symbol < 10) return 3;
    return symbol < 50 ? 4 : 5;
  }

  std::int32_t CodeDifference(Coder& coder, std::int32_t predicted, std::size_t context,
                              std::int64_t* time) {
    const std::int32_t difference =
        corrections_.Code(coder, predicted, static_cast<std::int32_t>(Since(*time)), context);
    *time = static_cast<std::int64_t>(Unsigned(last_) + Unsigned(difference));
    return difference;
  }

  std::uint32_t Choose(std::int64_t time) const {
    if (time == last_) return kRepeat;
    if (!IsClose(time)) return kNew;
    const float ratio = static_cast<float>(Since(time)) / static_cast<float>(difference_);
    return static_cast<std::uint32_t>(
        std::lround(std::clamp(ratio, 0.0f, static_cast<float>(kMost))));
  }

  SymbolModel first_{3};
  SymbolModel multiple_{512};
  IntegerModel<32> corrections_{6};
  std::int64_t last_ = 0;
  std::int32_t difference_ = 0;
  int extremes_ = 0;
};

}  // namespace dn::lidar_internal::laz
