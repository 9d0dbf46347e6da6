#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace dn::lidar_internal::laz {

/// Adaptive probabilities of the symbols 0 to n - 1 of an arithmetic coder.
///
/// Each coded symbol raises its count. The probabilities follow the counts after ever longer
/// intervals, and the counts are halved when their sum exceeds 2^15.
/// Source: A. Said, Introduction to Arithmetic Coding, HPL-2004-76; parameters of LASzip.
class SymbolModel {
 public:
  static constexpr std::uint32_t kBits = 15;  ///< cumulative probabilities are multiples of 2^-15

  SymbolModel() = default;
  explicit SymbolModel(std::uint32_t symbols);

  /// Returns false for a model without symbols, which cannot code.
  bool ready() const { return symbols_ != 0; }
  std::uint32_t last() const { return symbols_ - 1; }
  /// Returns the cumulative probability below a symbol, in units of 2^-15.
  std::uint32_t below(std::uint32_t symbol) const { return numbers_[symbol]; }

  /// Returns the last symbol with below(symbol) <= level.
  std::uint32_t Find(std::uint32_t level) const {
    const std::uint16_t* below = numbers_.data();
    std::uint32_t symbol = below[table_at_ + (level >> shift_)];
    while (symbol + 1 < symbols_ && below[symbol + 1] <= level) ++symbol;
    return symbol;
  }

  /// Records that a symbol was coded.
  void Count(std::uint32_t symbol) {
    ++numbers_[counts_at_ + symbol];
    if (--until_update_ == 0) Update();
  }

 private:
  void Update();
  void Spread();

  std::vector<std::uint16_t> numbers_;  ///< cumulative probabilities, counts, first symbols
  std::uint32_t symbols_ = 0;
  std::uint32_t counts_at_ = 0;
  std::uint32_t table_at_ = 0;
  std::uint32_t shift_ = 0;  ///< the table has an entry for each level >> shift_
  std::uint32_t total_ = 0;
  std::uint32_t interval_ = 0;
  std::uint32_t until_update_ = 0;
};

/// Adaptive probability of a bit.
class BitModel {
 public:
  static constexpr std::uint32_t kBits = 13;  ///< the probability is a multiple of 2^-13

  /// Returns the probability of a zero, in units of 2^-13.
  std::uint32_t zero() const { return zero_; }

  /// Records that a bit was coded.
  void Count(std::uint32_t bit) {
    zeros_ += 1 - bit;
    if (--until_update_ == 0) Update();
  }

 private:
  void Update();

  std::uint32_t zero_ = 1u << (kBits - 1);
  std::uint32_t zeros_ = 1;
  std::uint32_t total_ = 2;
  std::uint32_t interval_ = 4;
  std::uint32_t until_update_ = 4;
};

/// Symbol models of the same size, each created at its first use.
class SymbolModels {
 public:
  SymbolModels(std::size_t count, std::uint32_t symbols) : models_(count), symbols_(symbols) {}

  SymbolModel& operator[](std::size_t index) {
    SymbolModel& model = models_[index];
    if (!model.ready()) model = SymbolModel(symbols_);
    return model;
  }

 private:
  std::vector<SymbolModel> models_;
  std::uint32_t symbols_;
};

}  // namespace dn::lidar_internal::laz
