#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "arithmetic_coder.h"

namespace dn::lidar_internal::laz {

/// Codes integers of `kBits` bits by their difference from a prediction.
///
/// First the width k of the difference c is coded, in one of several contexts: c lies between
/// -(2^k - 1) and 2^k. Then follow the upper 8 bits of its position there, and the rest without a
/// model. Values and predictions below 32 bits are taken modulo 2^kBits.
template <std::uint32_t kBits>
class IntegerModel {
 public:
  explicit IntegerModel(std::size_t contexts = 1) : widths_(contexts, kBits + 1) {}

  /// Codes a value; see Decoder.
  template <class Coder>
  std::int32_t Code(Coder& coder, std::int32_t predicted, std::int32_t value,
                    std::size_t context = 0) {
    std::uint32_t c = 0;
    if constexpr (Coder::kWrites) {
      c = Fold(static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(predicted));
      width_ = Width(c);
    }
    width_ = coder.Symbol(widths_[context], width_);
    c = CodeDifference(coder, c);
    const std::uint32_t coded = static_cast<std::uint32_t>(predicted) + c;
    if constexpr (kBits == 32) return static_cast<std::int32_t>(coded);
    return static_cast<std::int32_t>(coded & kMask);
  }

  /// Width of the difference that was coded last.
  std::uint32_t width() const { return width_; }

 private:
  static constexpr std::uint32_t kMask = kBits == 32 ? 0xFFFFFFFFu : (1u << kBits % 32) - 1;
  static constexpr std::uint32_t kHighBits = 8;

  /// Maps a difference to the signed number of kBits bits with the same remainder.
  static std::uint32_t Fold(std::uint32_t c) {
    if constexpr (kBits == 32) return c;
    const std::uint32_t sign = 1u << (kBits - 1);
    return ((c & kMask) ^ sign) - sign;
  }

  static std::uint32_t Width(std::uint32_t c) {
    const bool positive = static_cast<std::int32_t>(c) > 0;
    return static_cast<std::uint32_t>(std::bit_width(positive ? c - 1 : 0u - c));
  }

  template <class Coder>
  std::uint32_t CodeDifference(Coder& coder, std::uint32_t c) {
    if (width_ == 0) return coder.Bit(zero_or_one_, c);
    if (width_ == 32) return 1u << 31;
    const std::uint32_t negatives = (1u << width_) - 1;
    const std::uint32_t place = static_cast<std::int32_t>(c) > 0 ? c - 1 : c + negatives;
    const std::uint32_t coded = CodePlace(coder, place);
    return coded >= 1u << (width_ - 1) ? coded + 1 : coded - negatives;
  }

  /// Codes the position within the interval of the differences of this width.
  template <class Coder>
  std::uint32_t CodePlace(Coder& coder, std::uint32_t place) {
    SymbolModel& high = highs_[width_];
    if (!high.ready()) high = SymbolModel(1u << std::min(width_, kHighBits));
    if (width_ <= kHighBits) return coder.Symbol(high, place);
    const std::uint32_t bits = width_ - kHighBits;
    const std::uint32_t upper = coder.Symbol(high, place >> bits);
    return upper << bits | coder.Raw(bits, place & ((1u << bits) - 1));
  }

  SymbolModels widths_;
  BitModel zero_or_one_;
  std::array<SymbolModel, kBits + 1> highs_;
  std::uint32_t width_ = 0;
};

}  // namespace dn::lidar_internal::laz
