#include "arithmetic_model.h"

#include <algorithm>

namespace dn::lidar_internal::laz {
namespace {

constexpr std::uint32_t kOne = 1u << 31;  // fixed-point one of the probabilities before rounding
constexpr std::uint32_t kMostCounts = 1u << SymbolModel::kBits;
constexpr std::uint32_t kMostBits = 1u << BitModel::kBits;
constexpr std::uint32_t kLongestBitInterval = 64;
// Levels reach 2^15 + 63, because the decoder divides by a length that is rounded down.
constexpr std::uint32_t kLevels = kMostCounts + 64;

std::uint32_t FirstInterval(std::uint32_t symbols) { return (symbols + 6) / 2; }

std::uint32_t LongestInterval(std::uint32_t symbols) { return (symbols + 6) * 8; }

/// Returns the shift of levels for which the table has about as many entries as symbols.
std::uint32_t TableShift(std::uint32_t symbols) {
  std::uint32_t bits = 3;
  while (symbols > 1u << bits) ++bits;
  return SymbolModel::kBits - bits;
}

}  // namespace

SymbolModel::SymbolModel(std::uint32_t symbols)
    : symbols_(symbols),
      counts_at_(symbols),
      table_at_(2 * symbols),
      shift_(TableShift(symbols)),
      total_(symbols) {
  numbers_.resize(table_at_ + (kLevels >> shift_) + 1);
  std::fill_n(numbers_.begin() + counts_at_, symbols, std::uint16_t{1});
  Spread();
  interval_ = until_update_ = FirstInterval(symbols);
}

void SymbolModel::Update() {
  total_ += interval_;
  if (total_ > kMostCounts) {
    total_ = 0;
    for (std::uint32_t k = 0; k < symbols_; ++k) {
      std::uint16_t& count = numbers_[counts_at_ + k];
      count = static_cast<std::uint16_t>((count + 1) / 2);
      total_ += count;
    }
  }
  Spread();
  interval_ = std::min(5 * interval_ / 4, LongestInterval(symbols_));
  until_update_ = interval_;
}

/// Computes the cumulative probabilities from the counts, and the table of the first symbols.
void SymbolModel::Spread() {
  const std::uint32_t scale = kOne / total_;
  const std::uint16_t* counts = numbers_.data() + counts_at_;
  std::uint16_t* table = numbers_.data() + table_at_;
  std::uint32_t sum = 0, filled = 0;
  for (std::uint32_t k = 0; k < symbols_; ++k) {
    const std::uint32_t below = (scale * sum) >> (31 - kBits);
    numbers_[k] = static_cast<std::uint16_t>(below);
    sum += counts[k];
    for (; filled <= below >> shift_; ++filled) {
      table[filled] = static_cast<std::uint16_t>(k > 0 ? k - 1 : 0);
    }
  }
  for (; filled <= kLevels >> shift_; ++filled) {
    table[filled] = static_cast<std::uint16_t>(symbols_ - 1);
  }
}

void BitModel::Update() {
  total_ += interval_;
  if (total_ > kMostBits) {
    total_ = (total_ + 1) / 2;
    zeros_ = (zeros_ + 1) / 2;
    if (zeros_ == total_) ++total_;
  }
  zero_ = (zeros_ * (kOne / total_)) >> (31 - kBits);
  interval_ = std::min(5 * interval_ / 4, kLongestBitInterval);
  until_update_ = interval_;
}

}  // namespace dn::lidar_internal::laz
