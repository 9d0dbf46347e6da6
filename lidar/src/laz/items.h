#pragma once

#include <cstddef>
#include <vector>

#include "arithmetic_coder.h"

namespace dn::lidar_internal::laz {

/// A part of each record that is coded point by point, all items with the same coder.
template <class Coder>
class PointItem {
 public:
  virtual ~PointItem() = default;

  /// Sets the part of the first record of a chunk, which is stored without compression.
  virtual void Start(const char* first) = 0;

  /// Codes the part of the next record; a decoder fills it.
  virtual void Code(Coder& coder, typename Coder::Byte* part) = 0;
};

/// The compressed values of one attribute of all points of a chunk.
template <class Coder>
struct Layer {
  Coder coder;
  /// A decoder reads the layer; an encoder has met a value that differs from the one before.
  bool used = false;
};

/// A part of each record that is coded in layers.
template <class Coder>
class LayeredItem {
 public:
  explicit LayeredItem(std::size_t layers) : layers_(layers) {}
  virtual ~LayeredItem() = default;

  /// Sets the part of the first record of a chunk, and its scanner channel.
  virtual void Start(const char* first, std::size_t channel) = 0;

  /// Codes the part of the next record. The item POINT14 sets `channel`, which the others use. In
  /// version 3 it only does so for a point whose channel differs from that of the point before.
  virtual void Code(typename Coder::Byte* part, std::size_t* channel) = 0;

  std::vector<Layer<Coder>>& layers() { return layers_; }

 protected:
  std::vector<Layer<Coder>> layers_;
};

/// The state of an item for each of the four scanner channels.
///
/// State has a constructor from `const Last&` and a member `last`. In version 3 of the items, the
/// point before predicts the first point after a return to a channel. That point then replaces the
/// value of the other channel. This error of the first programs is part of the format. Version 4
/// uses the last point of the channel.
template <class State, class Last>
class Channels {
 public:
  static constexpr std::size_t kCount = 4;

  explicit Channels(int version) : version_(version) {}

  void Start(const Last& first, std::size_t channel) {
    states_.clear();
    states_.resize(kCount);
    current_ = channel;
    states_[channel].emplace_back(first);
  }

  /// Selects the channel of the next point; returns the value that predicts it.
  Last& Select(std::size_t channel) {
    Last& before = state().last;
    if (channel == current_) return before;
    current_ = channel;
    if (!states_[channel].empty()) return version_ >= 4 ? state().last : before;
    states_[channel].emplace_back(before);
    return state().last;
  }

  State& state() { return states_[current_].front(); }

 private:
  int version_;
  std::size_t current_ = 0;
  std::vector<std::vector<State>> states_;  ///< of each channel; empty until its first point
};

}  // namespace dn::lidar_internal::laz
