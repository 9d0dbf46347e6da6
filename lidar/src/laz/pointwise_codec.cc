#include "pointwise_codec.h"

#include <utility>

#include "colours.h"
#include "extra_bytes.h"
#include "point10.h"
#include "point_times.h"
#include "wave_packets.h"

namespace dn::lidar_internal::laz {
namespace {

template <class Coder>
std::unique_ptr<PointItem<Coder>> MakePointItem(const Item& item) {
  const bool old = item.version == 1;
  switch (item.type) {
    case ItemType::kPoint10:
      if (old) return std::make_unique<OldPoint10<Coder>>();
      return std::make_unique<Point10<Coder>>();
    case ItemType::kGpsTime11:
      if (old) return std::make_unique<OldPointTimes<Coder>>();
      return std::make_unique<PointTimes<Coder>>();
    case ItemType::kRgb12:
      if (old) return std::make_unique<OldColours<Coder>>();
      return std::make_unique<Colours<Coder>>();
    case ItemType::kWavePacket13:
      return std::make_unique<WavePackets<Coder>>();
    default:
      if (old) return std::make_unique<OldExtraBytes<Coder>>(item.bytes);
      return std::make_unique<ExtraBytes<Coder>>(item.bytes);
  }
}

/// The items of a record and their state.
template <class Coder>
class PointwiseRecord {
 public:
  explicit PointwiseRecord(const Compression& compression) {
    for (const Item& item : compression.items) {
      items_.push_back({MakePointItem<Coder>(item), bytes_});
      bytes_ += item.bytes;
    }
  }

  std::size_t bytes() const { return bytes_; }

  void Start(const char* record) {
    for (const Part& part : items_) part.item->Start(record + part.at);
  }

  void Code(Coder& coder, typename Coder::Byte* record) {
    for (const Part& part : items_) part.item->Code(coder, record + part.at);
  }

 private:
  struct Part {
    std::unique_ptr<PointItem<Coder>> item;
    std::size_t at;
  };

  std::vector<Part> items_;
  std::size_t bytes_ = 0;
};

class PointwiseDecoder final : public ChunkDecoder {
 public:
  PointwiseDecoder(const Compression& compression, ByteSource source)
      : record_(compression), source_(std::move(source)) {}

  void Read(std::size_t count, char* records) override {
    for (std::size_t i = 0; i < count; ++i, ++read_, records += record_.bytes()) {
      if (read_ == 0) {
        source_.Read(records, record_.bytes());
        record_.Start(records);
        continue;
      }
      if (read_ == 1) decoder_.Start(&source_);
      record_.Code(decoder_, records);
    }
  }

 private:
  PointwiseRecord<Decoder> record_;
  ByteSource source_;
  Decoder decoder_;
  std::uint64_t read_ = 0;
};

class PointwiseEncoder final : public ChunkEncoder {
 public:
  explicit PointwiseEncoder(const Compression& compression) : record_(compression) {}

  void Append(const char* record) override {
    if (first_.empty()) {
      first_.assign(record, record_.bytes());
      record_.Start(record);
      encoder_.Start();
    } else {
      record_.Code(encoder_, record);
    }
  }

  std::string Finish() override {
    encoder_.Finish();
    return first_ + encoder_.bytes();
  }

 private:
  PointwiseRecord<Encoder> record_;
  std::string first_;
  Encoder encoder_;
};

}  // namespace

std::unique_ptr<ChunkDecoder> DecodePointwise(const Compression& compression, ByteSource source) {
  return std::make_unique<PointwiseDecoder>(compression, std::move(source));
}

std::unique_ptr<ChunkEncoder> EncodePointwise(const Compression& compression) {
  return std::make_unique<PointwiseEncoder>(compression);
}

}  // namespace dn::lidar_internal::laz
