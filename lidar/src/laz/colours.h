#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "integer_model.h"
#include "items.h"

namespace dn::lidar_internal::laz {

/// Red, green and blue in record order: the low and the high byte of each.
using ColourBytes = std::array<std::uint8_t, 6>;

inline ColourBytes LoadColour(const char* part) {
  ColourBytes colour;
  std::copy_n(reinterpret_cast<const std::uint8_t*>(part), colour.size(), colour.begin());
  return colour;
}

/// Returns a bit for each byte that differs.
template <std::size_t kBytes>
std::uint32_t DifferentBytes(const std::array<std::uint8_t, kBytes>& a,
                             const std::array<std::uint8_t, kBytes>& b) {
  std::uint32_t different = 0;
  for (std::size_t i = 0; i < kBytes; ++i) different |= (a[i] != b[i] ? 1u : 0u) << i;
  return different;
}

/// Codes colours by their difference from a colour before. Differences of green and blue are
/// predicted from those of red, and of red and green. A single bit marks a grey value.
class ColourModel {
 public:
  /// Codes a colour; see Decoder. A decoder passes the colour before.
  template <class Coder>
  ColourBytes Code(Coder& coder, const ColourBytes& before, ColourBytes now) {
    std::uint32_t changes = 0;
    if constexpr (Coder::kWrites) changes = FindChanges(before, now);
    changes = coder.Symbol(changes_, changes);
    const ColourBytes wanted = now;
    const auto code = [&](std::size_t i, int predicted) {
      now[i] = before[i];
      if ((changes >> i & 1) == 0) return;
      const auto difference = static_cast<std::uint8_t>(wanted[i] - predicted);
      now[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(predicted) +
                                         coder.Symbol(bytes_[i], difference));
    };
    code(0, before[0]);
    code(1, before[1]);
    if ((changes & kColoured) == 0) return {now[0], now[1], now[0], now[1], now[0], now[1]};
    const auto change = [&](std::size_t i) { return now[i] - before[i]; };
    for (const std::size_t part : {std::size_t{0}, std::size_t{1}}) {
      const std::size_t red = part, green = part + 2, blue = part + 4;
      code(green, Clamp(before[green] + change(red)));
      code(blue, Clamp(before[blue] + (change(red) + change(green)) / 2));
    }
    return now;
  }

 private:
  static constexpr std::uint32_t kColoured = 1u << 6;

  static int Clamp(int value) { return std::clamp(value, 0, 255); }

  static std::uint32_t FindChanges(const ColourBytes& before, const ColourBytes& now) {
    const bool grey = now[0] == now[2] && now[0] == now[4] && now[1] == now[3] && now[1] == now[5];
    return DifferentBytes(before, now) | (grey ? 0 : kColoured);
  }

  SymbolModel changes_{128};
  SymbolModels bytes_{6, 256};
};

/// Item RGB12, version 2.
template <class Coder>
class Colours final : public PointItem<Coder> {
 public:
  void Start(const char* first) override { last_ = LoadColour(first); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    ColourBytes now = last_;
    if constexpr (Coder::kWrites) now = LoadColour(part);
    last_ = model_.Code(coder, last_, now);
    if constexpr (!Coder::kWrites) std::copy_n(last_.begin(), last_.size(), part);
  }

 private:
  ColourBytes last_{};
  ColourModel model_;
};

/// Item RGB12, version 1.
template <class Coder>
class OldColours final : public PointItem<Coder> {
 public:
  void Start(const char* first) override { last_ = LoadColour(first); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    ColourBytes now = last_;
    if constexpr (Coder::kWrites) now = LoadColour(part);
    const std::uint32_t changes = coder.Symbol(changes_, DifferentBytes(last_, now));
    for (std::size_t i = 0; i < now.size(); ++i) {
      if ((changes >> i & 1) == 0) continue;
      now[i] = static_cast<std::uint8_t>(bytes_.Code(coder, last_[i], now[i], i));
    }
    last_ = now;
    if constexpr (!Coder::kWrites) std::copy_n(last_.begin(), last_.size(), part);
  }

 private:
  ColourBytes last_{};
  SymbolModel changes_{64};
  IntegerModel<8> bytes_{6};
};

/// Items RGB14 and RGBNIR14: a layer of colours, and with kInfrared a second one of the near
/// infrared value.
template <class Coder, bool kInfrared>
class LayeredColours final : public LayeredItem<Coder> {
 public:
  explicit LayeredColours(int version)
      : LayeredItem<Coder>(kInfrared ? 2 : 1), channels_(version) {}

  void Start(const char* first, std::size_t channel) override {
    channels_.Start(Load(first), channel);
  }

  void Code(typename Coder::Byte* part, std::size_t* channel) override {
    Pixel& last = channels_.Select(*channel);
    State& state = channels_.state();
    Pixel now = last;
    if constexpr (Coder::kWrites) now = Load(part);
    CodeColour(state, last, &now);
    if constexpr (kInfrared) CodeInfrared(state, last, &now);
    last = now;
    if constexpr (!Coder::kWrites) Store(now, part);
  }

 private:
  struct Pixel {
    ColourBytes colour{};
    std::array<std::uint8_t, 2> infrared{};
  };

  struct State {
    explicit State(const Pixel& before) : last(before) {}
    Pixel last;
    ColourModel colours;
    SymbolModel infrared_changes{4};
    SymbolModels infrared_bytes{2, 256};
  };

  static Pixel Load(const char* part) {
    Pixel pixel{LoadColour(part), {}};
    if constexpr (kInfrared) {
      pixel.infrared = {static_cast<std::uint8_t>(part[6]), static_cast<std::uint8_t>(part[7])};
    }
    return pixel;
  }

  static void Store(const Pixel& pixel, char* part) {
    part = std::copy_n(pixel.colour.begin(), pixel.colour.size(), part);
    if constexpr (kInfrared) std::copy_n(pixel.infrared.begin(), pixel.infrared.size(), part);
  }

  void CodeColour(State& state, const Pixel& last, Pixel* now) {
    Layer<Coder>& layer = this->layers_[0];
    if constexpr (Coder::kWrites) layer.used |= now->colour != last.colour;
    if (!Coder::kWrites && !layer.used) return;
    now->colour = state.colours.Code(layer.coder, last.colour, now->colour);
  }

  void CodeInfrared(State& state, const Pixel& last, Pixel* now) {
    Layer<Coder>& layer = this->layers_[1];
    if constexpr (Coder::kWrites) layer.used |= now->infrared != last.infrared;
    if (!Coder::kWrites && !layer.used) return;
    const std::uint32_t changes =
        layer.coder.Symbol(state.infrared_changes, DifferentBytes(last.infrared, now->infrared));
    for (std::size_t i = 0; i < 2; ++i) {
      if ((changes >> i & 1) == 0) continue;
      const auto difference = static_cast<std::uint8_t>(now->infrared[i] - last.infrared[i]);
      now->infrared[i] = static_cast<std::uint8_t>(
          last.infrared[i] + layer.coder.Symbol(state.infrared_bytes[i], difference));
    }
  }

  Channels<State, Pixel> channels_;
};

}  // namespace dn::lidar_internal::laz
