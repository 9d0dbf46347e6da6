#pragma once

#include <dn/geo/little_endian.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "gps_times.h"
#include "integer_model.h"
#include "items.h"
#include "point10.h"
#include "return_contexts.h"
#include "running_median.h"

namespace dn::lidar_internal::laz {

/// The first 30 bytes of the point formats 6 to 10.
struct Point14Fields {
  static constexpr std::size_t kBytes = 30;

  Point14Fields() = default;
  explicit Point14Fields(const char* part)
      : x(LoadLittleEndian<std::int32_t>(part)),
        y(LoadLittleEndian<std::int32_t>(part + 4)),
        z(LoadLittleEndian<std::int32_t>(part + 8)),
        intensity(LoadLittleEndian<std::uint16_t>(part + 12)),
        number(static_cast<std::uint8_t>(part[14] & 15)),
        count(static_cast<std::uint8_t>(part[14] >> 4 & 15)),
        flags(static_cast<std::uint8_t>((part[15] & 15) | (part[15] >> 2 & 0x30))),
        channel(static_cast<std::uint8_t>(part[15] >> 4 & 3)),
        classification(static_cast<std::uint8_t>(part[16])),
        user(static_cast<std::uint8_t>(part[17])),
        angle(LoadLittleEndian<std::uint16_t>(part + 18)),
        source(LoadLittleEndian<std::uint16_t>(part + 20)),
        time(LoadLittleEndian<std::int64_t>(part + 22)) {}

  void Store(char* part) const {
    StoreLittleEndian(x, part);
    StoreLittleEndian(y, part + 4);
    StoreLittleEndian(z, part + 8);
    StoreLittleEndian(intensity, part + 12);
    part[14] = static_cast<char>(number | count << 4);
    part[15] = static_cast<char>((flags & 15) | channel << 4 | (flags & 0x30) << 2);
    part[16] = static_cast<char>(classification);
    part[17] = static_cast<char>(user);
    StoreLittleEndian(angle, part + 18);
    StoreLittleEndian(source, part + 20);
    StoreLittleEndian(time, part + 22);
  }

  /// Returns a number that says whether the return is the first and whether it is the last.
  std::size_t place() const { return (number == 1 ? 1 : 0) + (number >= count ? 2 : 0); }

  std::int32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  std::uint8_t number = 0, count = 0;  ///< return number, number of returns
  std::uint8_t flags = 0;              ///< four flags of the class, scan direction, edge
  std::uint8_t channel = 0, classification = 0, user = 0;
  std::uint16_t angle = 0, source = 0;
  std::int64_t time = 0;  ///< integer with the bits of the GPS time
};

/// Item POINT14: nine layers. The first one has the coordinates x and y, the returns and the
/// channel. It also marks the points whose time, angle or source differ from the point before.
template <class Coder>
class Point14 final : public LayeredItem<Coder> {
 public:
  explicit Point14(int version) : LayeredItem<Coder>(9), version_(version), channels_(version) {}

  void Start(const char* first, std::size_t /*channel*/) override {
    const Point14Fields fields(first);
    channels_.Start(fields, fields.channel);
    // Decoders need these two layers even if all heights are equal.
    this->layers_[kPlane].used = this->layers_[kHeight].used = true;
  }

  void Code(typename Coder::Byte* part, std::size_t* channel) override {
    Point14Fields now;
    if constexpr (Coder::kWrites) now = Point14Fields(part);
    const std::uint32_t changes = CodeChanges(&now);
    if (version_ >= 4 || (changes & kChannelChange) != 0) *channel = now.channel;
    State& state = channels_.state();
    if constexpr (!Coder::kWrites) {
      const std::uint8_t selected = now.channel;
      now = state.last;
      now.channel = selected;
    }
    CodeReturns(state, changes, &now);
    const bool later = (changes & kTimeChange) != 0;
    CodePlane(state, later, &now);
    CodeHeight(state, &now);
    CodeClass(state, &now);
    CodeFlags(state, &now);
    CodeIntensity(state, later, &now);
    if ((changes & kAngleChange) != 0) CodeAngle(state, later, &now);
    CodeUser(state, &now);
    if ((changes & kSourceChange) != 0) CodeSource(state, &now);
    if (later) CodeTime(state, &now);
    state.last = now;
    state.later = later;
    if constexpr (!Coder::kWrites) now.Store(part);
  }

 private:
  enum LayerIndex : std::size_t {
    kPlane,
    kHeight,
    kClass,
    kFlags,
    kIntensity,
    kAngle,
    kUser,
    kSource,
    kTime
  };
  static constexpr std::uint32_t kNumberUp = 1, kNumberDown = 2, kNumberOther = 3, kCountChange = 4,
                                 kAngleChange = 8, kTimeChange = 16, kSourceChange = 32,
                                 kChannelChange = 64;

  struct State {
    explicit State(const Point14Fields& before) : last(before), times(before.time) {
      intensity.fill(before.intensity);
      height.fill(before.z);
    }

    Point14Fields last;
    bool later = false;  ///< the last point had another time than the one before
    std::array<std::uint16_t, 8> intensity{};
    std::array<RunningMedian, 12> x, y;
    std::array<std::int32_t, 8> height{};
    SymbolModels changes{8, 128};
    SymbolModel channel_steps{3};
    SymbolModels counts{16, 16}, numbers{16, 16};
    SymbolModel number_steps{13};
    IntegerModel<32> dx{2}, dy{22}, heights{20};
    SymbolModels classes{64, 256}, flags{64, 64}, users{64, 256};
    IntegerModel<16> intensities{4}, angles{2}, sources;
    GpsTimes<false> times;
  };

  Coder& coder(LayerIndex index) { return this->layers_[index].coder; }

  /// Returns true if the values of a layer are coded. Notes for an encoder if a value is new.
  bool IsCoded(LayerIndex index, bool differs) {
    Layer<Coder>& layer = this->layers_[index];
    if constexpr (Coder::kWrites) {
      layer.used |= differs;
      return true;
    }
    return layer.used;
  }

  /// Codes what differs from the point before, and selects the channel.
  std::uint32_t CodeChanges(Point14Fields* now) {
    const std::size_t before = channels_.state().last.channel;
    SymbolModels& models = channels_.state().changes;
    SymbolModel& steps = channels_.state().channel_steps;
    const std::size_t context = channels_.state().last.place() + (channels_.state().later ? 4 : 0);
    std::uint32_t changes = 0;
    if constexpr (Coder::kWrites) {
      channels_.Select(now->channel);
      changes =
          FindChanges(channels_.state().last, *now) | (now->channel != before ? kChannelChange : 0);
    }
    changes = coder(kPlane).Symbol(models[context], changes);
    std::size_t channel = before;
    if ((changes & kChannelChange) != 0) {
      const auto step = static_cast<std::uint32_t>((now->channel - before - 1) & 3);
      channel = (before + coder(kPlane).Symbol(steps, step) + 1) & 3;
    }
    channels_.Select(channel);
    now->channel = static_cast<std::uint8_t>(channel);
    return changes;
  }

  static std::uint32_t FindChanges(const Point14Fields& last, const Point14Fields& now) {
    const int step = (now.number - last.number) & 15;
    const std::uint32_t number = step == 0    ? 0
                                 : step == 1  ? kNumberUp
                                 : step == 15 ? kNumberDown
                                              : kNumberOther;
    return number | (now.count != last.count ? kCountChange : 0) |
           (now.angle != last.angle ? kAngleChange : 0) |
           (now.time != last.time ? kTimeChange : 0) |
           (now.source != last.source ? kSourceChange : 0);
  }

  void CodeReturns(State& state, std::uint32_t changes, Point14Fields* now) {
    const Point14Fields& last = state.last;
    if ((changes & kCountChange) != 0) {
      now->count =
          static_cast<std::uint8_t>(coder(kPlane).Symbol(state.counts[last.count], now->count));
    }
    const std::uint32_t step = changes & kNumberOther;
    if (step != kNumberOther) {
      constexpr std::array<std::uint8_t, 3> kSteps{0, 1, 15};
      now->number = static_cast<std::uint8_t>((last.number + kSteps[step]) & 15);
    } else if ((changes & kTimeChange) != 0) {
      now->number =
          static_cast<std::uint8_t>(coder(kPlane).Symbol(state.numbers[last.number], now->number));
    } else {
      const auto rest = static_cast<std::uint32_t>((now->number - last.number - 2) & 15);
      now->number = static_cast<std::uint8_t>(
          (last.number + coder(kPlane).Symbol(state.number_steps, rest) + 2) & 15);
    }
  }

  void CodePlane(State& state, bool later, Point14Fields* now) {
    const bool single = now->count == 1;
    const std::size_t m = 2 * ExtendedReturnContext(now->count, now->number) + (later ? 1 : 0);
    const std::int32_t dx = state.dx.Code(coder(kPlane), state.x[m].median(),
                                          Difference(now->x, state.last.x), single ? 1 : 0);
    now->x = Sum(state.last.x, dx);
    state.x[m].Add(dx);
    const std::int32_t dy =
        state.dy.Code(coder(kPlane), state.y[m].median(), Difference(now->y, state.last.y),
                      WidthContext(state.dx.width(), 20, single));
    now->y = Sum(state.last.y, dy);
    state.y[m].Add(dy);
  }

  void CodeHeight(State& state, Point14Fields* now) {
    if (!IsCoded(kHeight, true)) return;
    const std::size_t l = HeightContext(now->count, now->number);
    const std::uint32_t width = (state.dx.width() + state.dy.width()) / 2;
    now->z = state.heights.Code(coder(kHeight), state.height[l], now->z,
                                WidthContext(width, 18, now->count == 1));
    state.height[l] = now->z;
  }

  void CodeClass(State& state, Point14Fields* now) {
    const std::uint8_t last = state.last.classification;
    if (!IsCoded(kClass, now->classification != last)) return;
    const std::size_t context = 2 * (last & 31u) + (now->place() == 3 ? 1 : 0);
    now->classification = static_cast<std::uint8_t>(
        coder(kClass).Symbol(state.classes[context], now->classification));
  }

  void CodeFlags(State& state, Point14Fields* now) {
    const std::uint8_t last = state.last.flags;
    if (!IsCoded(kFlags, now->flags != last)) return;
    now->flags = static_cast<std::uint8_t>(coder(kFlags).Symbol(state.flags[last], now->flags));
  }

  void CodeIntensity(State& state, bool later, Point14Fields* now) {
    if (!IsCoded(kIntensity, now->intensity != state.last.intensity)) return;
    std::uint16_t& before = state.intensity[2 * now->place() + (later ? 1 : 0)];
    before = static_cast<std::uint16_t>(
        state.intensities.Code(coder(kIntensity), before, now->intensity, now->place()));
    now->intensity = before;
  }

  void CodeAngle(State& state, bool later, Point14Fields* now) {
    if (!IsCoded(kAngle, true)) return;
    now->angle = static_cast<std::uint16_t>(
        state.angles.Code(coder(kAngle), state.last.angle, now->angle, later ? 1 : 0));
  }

  void CodeUser(State& state, Point14Fields* now) {
    const std::uint8_t last = state.last.user;
    if (!IsCoded(kUser, now->user != last)) return;
    now->user = static_cast<std::uint8_t>(coder(kUser).Symbol(state.users[last / 4u], now->user));
  }

  void CodeSource(State& state, Point14Fields* now) {
    if (!IsCoded(kSource, true)) return;
    now->source = static_cast<std::uint16_t>(
        state.sources.Code(coder(kSource), state.last.source, now->source));
  }

  void CodeTime(State& state, Point14Fields* now) {
    if (!IsCoded(kTime, true)) return;
    now->time = state.times.Code(coder(kTime), now->time);
  }

  int version_;
  Channels<State, Point14Fields> channels_;
};

}  // namespace dn::lidar_internal::laz
