#pragma once

#include <cstdint>
#include <string>

#include "arithmetic_model.h"
#include "byte_source.h"

namespace dn::lidar_internal::laz {

/// Length of the interval from which on the coders output or input a byte.
inline constexpr std::uint32_t kLeastLength = 1u << 24;
inline constexpr std::uint32_t kWholeLength = 0xFFFFFFFFu;

/// Arithmetic decoder. Encoder has the same methods, so that one template of an item describes both
/// directions. Each method takes the value to encode and returns the coded value.
///
/// Source: A. Said, Introduction to Arithmetic Coding, HPL-2004-76.
class Decoder {
 public:
  static constexpr bool kWrites = false;
  using Byte = char;  ///< bytes of a record that is being filled

  /// Starts at the next byte of `source`, which must outlive the use of the decoder.
  void Start(ByteSource* source) {
    source_ = source;
    length_ = kWholeLength;
    value_ = 0;
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | source_->Next();
    // The value of an encoder lies below the length, and all steps preserve that.
    if (value_ == kWholeLength) FailBits();
  }

  std::uint32_t Symbol(SymbolModel& model, std::uint32_t /*unknown*/ = 0) {
    const std::uint32_t unit = length_ >> SymbolModel::kBits;
    const std::uint32_t symbol = model.Find(value_ / unit);
    const std::uint32_t low = model.below(symbol) * unit;
    length_ = (symbol == model.last() ? length_ : model.below(symbol + 1) * unit) - low;
    value_ -= low;
    Normalize();
    model.Count(symbol);
    return symbol;
  }

  std::uint32_t Bit(BitModel& model, std::uint32_t /*unknown*/ = 0) {
    const std::uint32_t low = model.zero() * (length_ >> BitModel::kBits);
    const std::uint32_t bit = value_ >= low ? 1 : 0;
    length_ = bit == 0 ? low : length_ - low;
    value_ -= bit == 0 ? 0 : low;
    Normalize();
    model.Count(bit);
    return bit;
  }

  /// Codes `bits` bits (1 to 31) without a model.
  std::uint32_t Raw(std::uint32_t bits, std::uint32_t /*unknown*/ = 0) {
    if (bits <= kMostRawBits) return RawPart(bits);
    const std::uint32_t low = RawPart(16);
    return RawPart(bits - 16) << 16 | low;
  }

 private:
  static constexpr std::uint32_t kMostRawBits = 19;

  std::uint32_t RawPart(std::uint32_t bits) {
    length_ >>= bits;
    const std::uint32_t value = value_ / length_;
    if (value >> bits != 0) FailBits();
    value_ -= value * length_;
    Normalize();
    return value;
  }

  void Normalize() {
    while (length_ < kLeastLength) {
      value_ = value_ << 8 | source_->Next();
      length_ <<= 8;
    }
  }

  [[noreturn]] static void FailBits() { throw Damaged("the compressed data are not valid"); }

  ByteSource* source_ = nullptr;
  std::uint32_t value_ = 0;
  std::uint32_t length_ = kWholeLength;
};

/// Arithmetic encoder; see Decoder.
class Encoder {
 public:
  static constexpr bool kWrites = true;
  using Byte = const char;  ///< bytes of a record that is being read

  void Start() {
    bytes_.clear();
    base_ = 0;
    length_ = kWholeLength;
  }

  std::uint32_t Symbol(SymbolModel& model, std::uint32_t symbol) {
    const std::uint32_t unit = length_ >> SymbolModel::kBits;
    const std::uint32_t low = model.below(symbol) * unit;
    length_ = (symbol == model.last() ? length_ : model.below(symbol + 1) * unit) - low;
    Raise(low);
    Normalize();
    model.Count(symbol);
    return symbol;
  }

  std::uint32_t Bit(BitModel& model, std::uint32_t bit) {
    const std::uint32_t low = model.zero() * (length_ >> BitModel::kBits);
    if (bit == 0) {
      length_ = low;
    } else {
      Raise(low);
      length_ -= low;
    }
    Normalize();
    model.Count(bit);
    return bit;
  }

  std::uint32_t Raw(std::uint32_t bits, std::uint32_t value) {
    constexpr std::uint32_t kMostRawBits = 19;
    if (bits <= kMostRawBits) {
      RawPart(bits, value);
    } else {
      RawPart(16, value & 0xFFFF);
      RawPart(bits - 16, value >> 16);
    }
    return value;
  }

  /// Writes the bytes that the decoder needs to finish. No value can be coded afterwards.
  void Finish();

  const std::string& bytes() const { return bytes_; }

 private:
  void RawPart(std::uint32_t bits, std::uint32_t value) {
    length_ >>= bits;
    Raise(value * length_);
    Normalize();
  }

  void Raise(std::uint32_t low) {
    base_ += low;
    if (base_ < low) Carry();
  }

  void Normalize() {
    while (length_ < kLeastLength) {
      bytes_ += static_cast<char>(base_ >> 24);
      base_ <<= 8;
      length_ <<= 8;
    }
  }

  void Carry();

  std::string bytes_;
  std::uint32_t base_ = 0;
  std::uint32_t length_ = kWholeLength;
};

/// Codes an unsigned number of 32 bits without a model.
template <class Coder>
std::uint32_t CodeRaw32(Coder& coder, std::uint32_t value) {
  const std::uint32_t low = coder.Raw(16, value & 0xFFFF);
  return coder.Raw(16, value >> 16) << 16 | low;
}

/// Codes an unsigned number of 64 bits without a model.
template <class Coder>
std::uint64_t CodeRaw64(Coder& coder, std::uint64_t value) {
  const std::uint64_t low = CodeRaw32(coder, static_cast<std::uint32_t>(value));
  return std::uint64_t{CodeRaw32(coder, static_cast<std::uint32_t>(value >> 32))} << 32 | low;
}

}  // namespace dn::lidar_internal::laz
