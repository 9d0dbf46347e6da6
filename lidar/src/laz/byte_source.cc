#include "byte_source.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace dn::lidar_internal::laz {
namespace {

constexpr std::uint64_t kBlockBytes = std::uint64_t{1} << 16;

}  // namespace

ByteSource::ByteSource(std::istream* in, std::uint64_t begin, std::uint64_t end)
    : in_(in), next_(begin), left_(end - begin) {}

void ByteSource::Refill() {
  if (left_ == 0) throw Damaged("the compressed data end too early");
  block_.resize(std::min(left_, kBlockBytes));
  in_->clear();
  in_->seekg(static_cast<std::streamoff>(next_));
  in_->read(block_.data(), static_cast<std::streamsize>(block_.size()));
  if (static_cast<std::size_t>(in_->gcount()) != block_.size()) {
    throw Damaged("byte " + std::to_string(next_) + " of the file cannot be read");
  }
  next_ += block_.size();
  left_ -= block_.size();
  at_ = block_.data();
  end_ = at_ + block_.size();
}

void ByteSource::Read(char* to, std::size_t count) {
  while (count > 0) {
    if (at_ == end_) Refill();
    const std::size_t part = std::min(count, static_cast<std::size_t>(end_ - at_));
    std::memcpy(to, at_, part);
    at_ += part;
    to += part;
    count -= part;
  }
}

}  // namespace dn::lidar_internal::laz
