#pragma once

#include <dn/geo/little_endian.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "integer_model.h"
#include "items.h"
#include "return_contexts.h"
#include "running_median.h"

namespace dn::lidar_internal::laz {

/// The first 20 bytes of the point formats 0 to 5.
struct Point10Fields {
  static constexpr std::size_t kBytes = 20;

  Point10Fields() = default;
  explicit Point10Fields(const char* part)
      : x(LoadLittleEndian<std::int32_t>(part)),
        y(LoadLittleEndian<std::int32_t>(part + 4)),
        z(LoadLittleEndian<std::int32_t>(part + 8)),
        intensity(LoadLittleEndian<std::uint16_t>(part + 12)),
        returns(static_cast<std::uint8_t>(part[14])),
        classification(static_cast<std::uint8_t>(part[15])),
        angle(static_cast<std::uint8_t>(part[16])),
        user(static_cast<std::uint8_t>(part[17])),
        source(LoadLittleEndian<std::uint16_t>(part + 18)) {}

  void Store(char* part) const {
    StoreLittleEndian(x, part);
    StoreLittleEndian(y, part + 4);
    StoreLittleEndian(z, part + 8);
    StoreLittleEndian(intensity, part + 12);
    part[14] = static_cast<char>(returns);
    part[15] = static_cast<char>(classification);
    part[16] = static_cast<char>(angle);
    part[17] = static_cast<char>(user);
    StoreLittleEndian(source, part + 18);
  }

  std::size_t number() const { return returns & 7; }
  std::size_t count() const { return returns >> 3 & 7; }

  std::int32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  std::uint8_t returns = 0;  ///< return number, number of returns, scan direction, edge
  std::uint8_t classification = 0, angle = 0, user = 0;
  std::uint16_t source = 0;
};

/// Returns a difference of integers that may overflow.
inline std::int32_t Difference(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

/// Returns a sum of integers that may overflow.
inline std::int32_t Sum(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

/// Item POINT10, version 2.
template <class Coder>
class Point10 final : public PointItem<Coder> {
 public:
  void Start(const char* first) override { last_ = Point10Fields(first); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    Point10Fields now = last_;
    if constexpr (Coder::kWrites) now = Point10Fields(part);
    CodeAttributes(coder, &now);
    CodePosition(coder, &now);
    if constexpr (!Coder::kWrites) now.Store(part);
    last_ = now;
  }

 private:
  static constexpr std::uint32_t kSource = 1, kUser = 2, kAngle = 4, kClass = 8, kIntensity = 16,
                                 kReturns = 32;

  std::uint32_t FindChanges(const Point10Fields& now) const {
    const std::size_t m = ReturnContext(now.count(), now.number());
    return (now.source != last_.source ? kSource : 0) | (now.user != last_.user ? kUser : 0) |
           (now.angle != last_.angle ? kAngle : 0) |
           (now.classification != last_.classification ? kClass : 0) |
           (now.intensity != intensity_[m] ? kIntensity : 0) |
           (now.returns != last_.returns ? kReturns : 0);
  }

  void CodeAttributes(Coder& coder, Point10Fields* now) {
    std::uint32_t changes = 0;
    if constexpr (Coder::kWrites) changes = FindChanges(*now);
    changes = coder.Symbol(changes_, changes);
    if ((changes & kReturns) != 0) {
      now->returns = Byte(coder.Symbol(returns_[last_.returns], now->returns));
    }
    const std::size_t m = ReturnContext(now->count(), now->number());
    if ((changes & kIntensity) != 0) {
      intensity_[m] = static_cast<std::uint16_t>(
          intensities_.Code(coder, intensity_[m], now->intensity, std::min<std::size_t>(m, 3)));
    }
    now->intensity = intensity_[m];
    if ((changes & kClass) != 0) {
      now->classification = Byte(coder.Symbol(classes_[last_.classification], now->classification));
    }
    if ((changes & kAngle) != 0) {
      const std::size_t direction = now->returns >> 6 & 1;
      now->angle =
          Byte(last_.angle + coder.Symbol(angles_[direction], Byte(now->angle - last_.angle)));
    }
    if ((changes & kUser) != 0) now->user = Byte(coder.Symbol(users_[last_.user], now->user));
    if ((changes & kSource) != 0) {
      now->source = static_cast<std::uint16_t>(sources_.Code(coder, last_.source, now->source));
    }
  }

  void CodePosition(Coder& coder, Point10Fields* now) {
    const bool single = now->count() == 1;
    const std::size_t m = ReturnContext(now->count(), now->number());
    const std::size_t l = HeightContext(now->count(), now->number());
    const std::int32_t dx =
        dx_.Code(coder, x_[m].median(), Difference(now->x, last_.x), single ? 1 : 0);
    now->x = Sum(last_.x, dx);
    x_[m].Add(dx);
    const std::int32_t dy = dy_.Code(coder, y_[m].median(), Difference(now->y, last_.y),
                                     WidthContext(dx_.width(), 20, single));
    now->y = Sum(last_.y, dy);
    y_[m].Add(dy);
    const std::uint32_t width = (dx_.width() + dy_.width()) / 2;
    now->z = heights_.Code(coder, height_[l], now->z, WidthContext(width, 18, single));
    height_[l] = now->z;
  }

  static std::uint8_t Byte(std::uint32_t value) { return static_cast<std::uint8_t>(value); }

  Point10Fields last_;
  std::array<std::uint16_t, 16> intensity_{};
  std::array<RunningMedian, 16> x_, y_;
  std::array<std::int32_t, 8> height_{};
  SymbolModel changes_{64};
  SymbolModels returns_{256, 256}, classes_{256, 256}, angles_{2, 256}, users_{256, 256};
  IntegerModel<16> intensities_{4}, sources_;
  IntegerModel<32> dx_{2}, dy_{22}, heights_{20};
};

/// Item POINT10, version 1.
template <class Coder>
class OldPoint10 final : public PointItem<Coder> {
 public:
  void Start(const char* first) override { last_ = Point10Fields(first); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    Point10Fields now = last_;
    if constexpr (Coder::kWrites) now = Point10Fields(part);
    CodeAttributes(coder, CodePosition(coder, &now), &now);
    if constexpr (!Coder::kWrites) now.Store(part);
    last_ = now;
  }

 private:
  static constexpr std::uint32_t kSource = 1, kUser = 2, kAngle = 4, kClass = 8, kReturns = 16,
                                 kIntensity = 32;
  static constexpr std::uint32_t kMostWidth = 19;

  static std::int32_t Median(const std::array<std::int32_t, 3>& of) {
    return std::max(std::min(of[0], of[1]), std::min(std::max(of[0], of[1]), of[2]));
  }

  /// Returns the mean width of the differences in x and y.
  std::uint32_t CodePosition(Coder& coder, Point10Fields* now) {
    const std::int32_t dx = dx_.Code(coder, Median(x_), Difference(now->x, last_.x));
    now->x = Sum(last_.x, dx);
    const std::int32_t dy =
        dy_.Code(coder, Median(y_), Difference(now->y, last_.y), std::min(dx_.width(), kMostWidth));
    now->y = Sum(last_.y, dy);
    const std::uint32_t width = (dx_.width() + dy_.width()) / 2;
    now->z = heights_.Code(coder, last_.z, now->z, std::min(width, kMostWidth));
    x_[oldest_] = dx;
    y_[oldest_] = dy;
    oldest_ = (oldest_ + 1) % 3;
    return width;
  }

  std::uint32_t FindChanges(const Point10Fields& now) const {
    return (now.source != last_.source ? kSource : 0) | (now.user != last_.user ? kUser : 0) |
           (now.angle != last_.angle ? kAngle : 0) |
           (now.classification != last_.classification ? kClass : 0) |
           (now.returns != last_.returns ? kReturns : 0) |
           (now.intensity != last_.intensity ? kIntensity : 0);
  }

  void CodeAttributes(Coder& coder, std::uint32_t width, Point10Fields* now) {
    std::uint32_t changes = 0;
    if constexpr (Coder::kWrites) changes = FindChanges(*now);
    changes = coder.Symbol(changes_, changes);
    if ((changes & kIntensity) != 0) {
      now->intensity =
          static_cast<std::uint16_t>(intensities_.Code(coder, last_.intensity, now->intensity));
    }
    if ((changes & kReturns) != 0) {
      now->returns = Byte(coder.Symbol(returns_[last_.returns], now->returns));
    }
    if ((changes & kClass) != 0) {
      now->classification = Byte(coder.Symbol(classes_[last_.classification], now->classification));
    }
    if ((changes & kAngle) != 0) {
      now->angle = static_cast<std::uint8_t>(
          angles_.Code(coder, last_.angle, now->angle, width < 3 ? 1 : 0));
    }
    if ((changes & kUser) != 0) now->user = Byte(coder.Symbol(users_[last_.user], now->user));
    if ((changes & kSource) != 0) {
      now->source = static_cast<std::uint16_t>(sources_.Code(coder, last_.source, now->source));
    }
  }

  static std::uint8_t Byte(std::uint32_t value) { return static_cast<std::uint8_t>(value); }

  Point10Fields last_;
  std::array<std::int32_t, 3> x_{}, y_{};
  std::size_t oldest_ = 0;
  SymbolModel changes_{64};
  SymbolModels returns_{256, 256}, classes_{256, 256}, users_{256, 256};
  IntegerModel<8> angles_{2};
  IntegerModel<16> intensities_, sources_;
  IntegerModel<32> dx_, dy_{20}, heights_{20};
};

}  // namespace dn::lidar_internal::laz
