#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "integer_model.h"
#include "items.h"

namespace dn::lidar_internal::laz {

/// Item BYTE, version 2: each byte by its difference.
template <class Coder>
class ExtraBytes final : public PointItem<Coder> {
 public:
  explicit ExtraBytes(std::size_t bytes) : last_(bytes, '\0'), models_(bytes, 256) {}

  void Start(const char* first) override { last_.assign(first, last_.size()); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    for (std::size_t i = 0; i < last_.size(); ++i) {
      const auto difference = static_cast<std::uint8_t>(part[i] - last_[i]);
      last_[i] = static_cast<char>(static_cast<std::uint8_t>(last_[i]) +
                                   coder.Symbol(models_[i], difference));
      if constexpr (!Coder::kWrites) part[i] = last_[i];
    }
  }

 private:
  std::string last_;
  SymbolModels models_;
};

/// Item BYTE, version 1.
template <class Coder>
class OldExtraBytes final : public PointItem<Coder> {
 public:
  explicit OldExtraBytes(std::size_t bytes) : last_(bytes, '\0'), model_(bytes) {}

  void Start(const char* first) override { last_.assign(first, last_.size()); }

  void Code(Coder& coder, typename Coder::Byte* part) override {
    for (std::size_t i = 0; i < last_.size(); ++i) {
      last_[i] = static_cast<char>(model_.Code(coder, static_cast<std::uint8_t>(last_[i]),
                                               static_cast<std::uint8_t>(part[i]), i));
      if constexpr (!Coder::kWrites) part[i] = last_[i];
    }
  }

 private:
  std::string last_;
  IntegerModel<8> model_;
};

/// Item BYTE14: a layer for each byte.
template <class Coder>
class LayeredExtraBytes final : public LayeredItem<Coder> {
 public:
  LayeredExtraBytes(std::size_t bytes, int version)
      : LayeredItem<Coder>(bytes), channels_(version) {}

  void Start(const char* first, std::size_t channel) override {
    channels_.Start(std::string(first, this->layers_.size()), channel);
  }

  void Code(typename Coder::Byte* part, std::size_t* channel) override {
    std::string& last = channels_.Select(*channel);
    State& state = channels_.state();
    for (std::size_t i = 0; i < last.size(); ++i) {
      Layer<Coder>& layer = this->layers_[i];
      const auto difference = static_cast<std::uint8_t>(part[i] - last[i]);
      if constexpr (Coder::kWrites) layer.used |= difference != 0;
      if (Coder::kWrites || layer.used) {
        last[i] = static_cast<char>(static_cast<std::uint8_t>(last[i]) +
                                    layer.coder.Symbol(state.models[i], difference));
      }
      if constexpr (!Coder::kWrites) part[i] = last[i];
    }
  }

 private:
  struct State {
    explicit State(const std::string& before) : last(before), models(before.size(), 256) {}
    std::string last;
    SymbolModels models;
  };

  Channels<State, std::string> channels_;
};

}  // namespace dn::lidar_internal::laz
