#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

#include "testing/las_bytes.h"

namespace dn::testing {

/// Records of scan lines with several returns per pulse and times that jump. Channels, colours,
/// waveforms and extra bytes change now and then.
class LazRecords {
 public:
  LazRecords(int format, std::size_t extra_bytes, std::size_t points, unsigned seed)
      : format_(format),
        record_bytes_(LasBytes::FormatBytes(format) + extra_bytes),
        random_(seed),
        record_(record_bytes_, '\0') {
    for (std::size_t i = 0; i < points; ++i) {
      Step();
      bytes_ += record_;
    }
  }

  std::size_t record_bytes() const { return record_bytes_; }
  const std::string& bytes() const { return bytes_; }

 private:
  bool OneIn(unsigned n) { return random_() % n == 0; }

  template <class T>
  void Put(T value, std::size_t at) {
    LasBytes::Put(value, at, &record_);
  }

  void Step() {
    if (number_ >= returns_) {
      StartPulse();
    } else {
      ++number_;
    }
    z_ -= static_cast<std::int32_t>(random_() % 40);
    Put(x_ + static_cast<std::int32_t>(random_() % 5), 0);
    Put(y_ + number_, 4);
    Put(z_, 8);
    Put(static_cast<std::uint16_t>(200 + random_() % 100), 12);
    PutReturns();
    for (std::size_t at = AfterTime(); at < record_bytes_; ++at) {
      if (OneIn(4)) record_[at] = static_cast<char>(record_[at] + static_cast<int>(random_() % 7));
      if (OneIn(200)) record_[at] = static_cast<char>(random_());
    }
  }

  void StartPulse() {
    number_ = 1;
    const unsigned most = OneIn(5) ? 7 : 2;
    returns_ = 1 + static_cast<int>(random_() % most);
    x_ += 100;
    y_ = std::abs(x_ % 20000) - 5000;
    if (OneIn(300)) x_ -= 90000;
    z_ = 30000 + y_ / 10;
    time_s_ += OneIn(20) ? 3.7e-5 : 5e-6;
    if (OneIn(50)) time_s_ += 2.5;
    if (OneIn(90)) time_s_ = 381000.0;
    if (OneIn(40)) source_ = static_cast<std::uint16_t>(random_() % 300);
    if (OneIn(8)) channel_ = static_cast<int>(random_() % 4);
    if (OneIn(10)) class_ = static_cast<int>(random_() % 32);
    if (OneIn(30)) user_ = static_cast<int>(random_() % 256);
    if (OneIn(3)) angle_ += OneIn(2) ? 1 : -1;
  }

  void PutReturns() {
    const bool edge = OneIn(50);
    if (format_ >= 6) {
      record_[14] = static_cast<char>(number_ | returns_ << 4);
      record_[15] = static_cast<char>((edge ? 0x82 : 0x40) | channel_ << 4);
      record_[16] = static_cast<char>(class_);
      record_[17] = static_cast<char>(user_);
      Put(static_cast<std::int16_t>(160 * angle_), 18);
      Put(source_, 20);
      Put(time_s_, 22);
    } else {
      record_[14] = static_cast<char>(number_ | returns_ << 3 | (edge ? 0x80 : 0x40));
      record_[15] = static_cast<char>(class_);
      record_[16] = static_cast<char>(angle_);
      record_[17] = static_cast<char>(user_);
      Put(source_, 18);
      if (HasTime()) Put(time_s_, 20);
    }
  }

  bool HasTime() const { return format_ != 0 && format_ != 2; }
  std::size_t AfterTime() const { return format_ >= 6 ? 30 : HasTime() ? 28 : 20; }

  int format_;
  std::size_t record_bytes_;
  std::mt19937 random_;
  std::string record_, bytes_;
  std::int32_t x_ = 0, y_ = 0, z_ = 0;
  double time_s_ = 381000.0;
  int number_ = 1, returns_ = 1, channel_ = 0, class_ = 2, user_ = 0, angle_ = -20;
  std::uint16_t source_ = 7;
};

}  // namespace dn::testing
