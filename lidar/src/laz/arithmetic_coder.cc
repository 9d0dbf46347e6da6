#include "arithmetic_coder.h"

namespace dn::lidar_internal::laz {

/// Adds one to the number that the written bytes form.
void Encoder::Carry() {
  std::size_t at = bytes_.size();
  while (bytes_[--at] == '\xFF') bytes_[at] = '\0';
  bytes_[at] = static_cast<char>(bytes_[at] + 1);
}

void Encoder::Finish() {
  // The first bytes select a number within the interval; zeros fill what the decoder reads ahead.
  const bool wide = length_ > 2 * kLeastLength;
  Raise(wide ? kLeastLength : kLeastLength >> 1);
  length_ = wide ? kLeastLength >> 1 : kLeastLength >> 9;
  Normalize();
  bytes_.append(wide ? 3 : 2, '\0');
}

}  // namespace dn::lidar_internal::laz
