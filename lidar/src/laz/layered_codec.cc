#include "layered_codec.h"

#include <dn/geo/little_endian.h>

#include <utility>

#include "colours.h"
#include "extra_bytes.h"
#include "point14.h"
#include "wave_packets.h"

namespace dn::lidar_internal::laz {
namespace {

template <class Coder>
std::unique_ptr<LayeredItem<Coder>> MakeLayeredItem(const Item& item) {
  switch (item.type) {
    case ItemType::kPoint14:
      return std::make_unique<Point14<Coder>>(item.version);
    case ItemType::kRgb14:
      return std::make_unique<LayeredColours<Coder, false>>(item.version);
    case ItemType::kRgbNir14:
      return std::make_unique<LayeredColours<Coder, true>>(item.version);
    case ItemType::kWavePacket14:
      return std::make_unique<LayeredWavePackets<Coder>>(item.version);
    default:
      return std::make_unique<LayeredExtraBytes<Coder>>(item.bytes, item.version);
  }
}

/// The items of a record and their state.
template <class Coder>
class LayeredRecord {
 public:
  explicit LayeredRecord(const Compression& compression) {
    for (const Item& item : compression.items) {
      items_.push_back({MakeLayeredItem<Coder>(item), bytes_});
      bytes_ += item.bytes;
    }
  }

  std::size_t bytes() const { return bytes_; }

  void Start(const char* record) {
    const std::size_t channel = Point14Fields(record).channel;
    for (const Part& part : items_) part.item->Start(record + part.at, channel);
  }

  void Code(typename Coder::Byte* record) {
    std::size_t channel = 0;
    for (const Part& part : items_) part.item->Code(record + part.at, &channel);
  }

  /// Calls `visit` with each layer in the order of the file.
  template <class Visit>
  void ForEachLayer(const Visit& visit) {
    for (const Part& part : items_) {
      for (Layer<Coder>& layer : part.item->layers()) visit(layer);
    }
  }

 private:
  struct Part {
    std::unique_ptr<LayeredItem<Coder>> item;
    std::size_t at;
  };

  std::vector<Part> items_;
  std::size_t bytes_ = 0;
};

class LayeredDecoder final : public ChunkDecoder {
 public:
  LayeredDecoder(const Compression& compression, std::uint64_t points, ByteSource source)
      : record_(compression), first_(record_.bytes(), '\0') {
    source.Read(first_.data(), first_.size());
    record_.Start(first_.data());
    const std::uint32_t counted = ReadNumber(&source);
    if (counted != points) {
      throw Damaged("a chunk of " + std::to_string(points) + " points says that it has " +
                    std::to_string(counted));
    }
    LoadLayers(&source);
    if (points > 1 && sources_.front().left() == 0) throw Damaged("a chunk lacks its first layer");
    StartLayers();
  }

  void Read(std::size_t count, char* records) override {
    for (std::size_t i = 0; i < count; ++i, records += record_.bytes()) {
      if (!first_.empty()) {
        first_.copy(records, first_.size());
        first_.clear();
      } else {
        record_.Code(records);
      }
    }
  }

 private:
  static std::uint32_t ReadNumber(ByteSource* source) {
    char bytes[4];
    source->Read(bytes, sizeof bytes);
    return LoadLittleEndian<std::uint32_t>(bytes);
  }

  void LoadLayers(ByteSource* source) {
    std::vector<std::uint32_t> sizes;
    std::uint64_t sum = 0;
    record_.ForEachLayer([&](Layer<Decoder>&) {
      sizes.push_back(ReadNumber(source));
      sum += sizes.back();
    });
    if (sum > source->left()) throw Damaged("the layers of a chunk are longer than the chunk");
    bytes_.resize(sum);
    source->Read(bytes_.data(), bytes_.size());
    sources_.reserve(sizes.size());  // the decoders keep pointers to the elements
    std::string_view rest(bytes_);
    record_.ForEachLayer([&](Layer<Decoder>& layer) {
      const std::uint32_t size = sizes[sources_.size()];
      sources_.emplace_back(rest.substr(0, size));
      rest.remove_prefix(size);
      layer.used = size > 0;
    });
  }

  void StartLayers() {
    auto source = sources_.begin();
    record_.ForEachLayer([&](Layer<Decoder>& layer) {
      if (layer.used) layer.coder.Start(&*source);
      ++source;
    });
  }

  LayeredRecord<Decoder> record_;
  std::string first_;  ///< the first record, until it is read
  std::string bytes_;
  std::vector<ByteSource> sources_;
};

class LayeredEncoder final : public ChunkEncoder {
 public:
  explicit LayeredEncoder(const Compression& compression) : record_(compression) {}

  void Append(const char* record) override {
    ++points_;
    if (!first_.empty()) return record_.Code(record);
    first_.assign(record, record_.bytes());
    record_.ForEachLayer([](Layer<Encoder>& layer) { layer.coder.Start(); });
    record_.Start(record);
  }

  std::string Finish() override {
    std::string chunk = first_, layers;
    AppendLittleEndian(points_, chunk);
    record_.ForEachLayer([&](Layer<Encoder>& layer) {
      std::uint32_t size = 0;
      if (layer.used) {
        layer.coder.Finish();
        layers += layer.coder.bytes();
        size = static_cast<std::uint32_t>(layer.coder.bytes().size());
      }
      AppendLittleEndian(size, chunk);
    });
    return chunk + layers;
  }

 private:
  LayeredRecord<Encoder> record_;
  std::string first_;
  std::uint32_t points_ = 0;
};

}  // namespace

std::unique_ptr<ChunkDecoder> DecodeLayered(const Compression& compression, std::uint64_t points,
                                            ByteSource source) {
  return std::make_unique<LayeredDecoder>(compression, points, std::move(source));
}

std::unique_ptr<ChunkEncoder> EncodeLayered(const Compression& compression) {
  return std::make_unique<LayeredEncoder>(compression);
}

}  // namespace dn::lidar_internal::laz
