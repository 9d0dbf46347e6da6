#pragma once

#include <dn/geo/little_endian.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "integer_model.h"
#include "items.h"

namespace dn::lidar_internal::laz {

/// The fields of a record that refer to its waveform. Floats are treated as integers.
struct WavePacket {
  static constexpr std::size_t kBytes = 29;

  WavePacket() = default;
  explicit WavePacket(const char* part)
      : descriptor(static_cast<std::uint8_t>(part[0])),
        at(LoadLittleEndian<std::uint64_t>(part + 1)),
        bytes(LoadLittleEndian<std::int32_t>(part + 9)),
        return_point(LoadLittleEndian<std::int32_t>(part + 13)) {
    for (std::size_t i = 0; i < 3; ++i) {
      direction[i] = LoadLittleEndian<std::int32_t>(part + 17 + 4 * i);
    }
  }

  void Store(char* part) const {
    part[0] = static_cast<char>(descriptor);
    StoreLittleEndian(at, part + 1);
    StoreLittleEndian(bytes, part + 9);
    StoreLittleEndian(return_point, part + 13);
    for (std::size_t i = 0; i < 3; ++i) StoreLittleEndian(direction[i], part + 17 + 4 * i);
  }

  bool operator==(const WavePacket&) const = default;

  std::uint8_t descriptor = 0;
  std::uint64_t at = 0;    ///< position of the waveform
  std::int32_t bytes = 0;  ///< length of the waveform
  std::int32_t return_point = 0;
  std::array<std::int32_t, 3> direction{};
};

/// Codes the references to waveforms by their differences.
class WavePacketModel {
 public:
  /// Codes a reference; see Decoder.
  template <class Coder>
  WavePacket Code(Coder& coder, const WavePacket& before, WavePacket now) {
    now.descriptor = static_cast<std::uint8_t>(coder.Symbol(descriptors_, now.descriptor));
    CodePlace(coder, before, &now);
    now.bytes = lengths_.Code(coder, before.bytes, now.bytes);
    now.return_point = return_points_.Code(coder, before.return_point, now.return_point);
    for (std::size_t i = 0; i < 3; ++i) {
      now.direction[i] = directions_.Code(coder, before.direction[i], now.direction[i], i);
    }
    return now;
  }

 private:
  static constexpr std::uint32_t kSame = 0, kNext = 1, kNear = 2, kFar = 3;

  static std::uint64_t After(const WavePacket& before) {
    return before.at + static_cast<std::uint32_t>(before.bytes);
  }

  static std::uint32_t FindStep(const WavePacket& before, std::uint64_t at) {
    if (at == before.at) return kSame;
    if (at == After(before)) return kNext;
    const auto since = static_cast<std::int64_t>(at - before.at);
    return since == static_cast<std::int32_t>(since) ? kNear : kFar;
  }

  template <class Coder>
  void CodePlace(Coder& coder, const WavePacket& before, WavePacket* now) {
    std::uint32_t step = 0;
    if constexpr (Coder::kWrites) step = FindStep(before, now->at);
    step_ = coder.Symbol(steps_[step_], step);
    if (step_ == kSame) now->at = before.at;
    if (step_ == kNext) now->at = After(before);
    if (step_ == kNear) {
      since_ = sinces_.Code(coder, since_, static_cast<std::int32_t>(now->at - before.at));
      now->at = before.at + static_cast<std::uint64_t>(std::int64_t{since_});
    }
    if (step_ == kFar) now->at = CodeRaw64(coder, now->at);
  }

  SymbolModel descriptors_{256};
  SymbolModels steps_{4, 4};
  IntegerModel<32> sinces_, lengths_, return_points_, directions_{3};
  std::uint32_t step_ = kSame;
  std::int32_t since_ = 0;
};

/// Item WAVEPACKET13.
template <class Coder>
class WavePackets final : public PointItem<Coder> {
 public:
  void Start(const char* first) override { last_ = WavePacket(first); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    WavePacket now;
    if constexpr (Coder::kWrites) now = WavePacket(part);
    last_ = model_.Code(coder, last_, now);
    if constexpr (!Coder::kWrites) last_.Store(part);
  }

 private:
  WavePacket last_;
  WavePacketModel model_;
};

/// Item WAVEPACKET14.
template <class Coder>
class LayeredWavePackets final : public LayeredItem<Coder> {
 public:
  explicit LayeredWavePackets(int version) : LayeredItem<Coder>(1), channels_(version) {}

  void Start(const char* first, std::size_t channel) override {
    channels_.Start(WavePacket(first), channel);
  }

  void Code(typename Coder::Byte* part, std::size_t* channel) override {
    Layer<Coder>& layer = this->layers_[0];
    WavePacket& last = channels_.Select(*channel);
    WavePacket now = last;
    if constexpr (Coder::kWrites) {
      now = WavePacket(part);
      layer.used |= now != last;
    }
    if (Coder::kWrites || layer.used) {
      now = channels_.state().model.Code(layer.coder, last, now);
    }
    last = now;
    if constexpr (!Coder::kWrites) now.Store(part);
  }

 private:
  struct State {
    explicit State(const WavePacket& before) : last(before) {}
    WavePacket last;
    WavePacketModel model;
  };

  Channels<State, WavePacket> channels_;
};

}  // namespace dn::lidar_internal::laz
