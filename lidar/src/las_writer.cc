#include "las_writer.h"

#include <dn/geo/little_endian.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace dn::lidar_internal {
namespace {

constexpr int kFloat = 9;
constexpr std::size_t kFloatBytes = 4;
constexpr std::size_t kCopyBytes = std::size_t{1} << 20;
constexpr std::size_t kMostWord = std::numeric_limits<std::uint16_t>::max();
constexpr const char* kSoftware = "dn";
constexpr std::size_t kSoftwareBytes = 32;

// Element of the covariance (row and column), with the name that filters.als_tpu of PDAL uses.
struct CovarianceElement {
  const char* name;
  int row, column;
};
constexpr std::array<CovarianceElement, 6> kElements{{{"VarianceX", 0, 0},
                                                      {"VarianceY", 1, 1},
                                                      {"VarianceZ", 2, 2},
                                                      {"CovarianceXY", 0, 1},
                                                      {"CovarianceXZ", 0, 2},
                                                      {"CovarianceYZ", 1, 2}}};

/// Describes the bytes of a record that have no descriptor yet, so that more attributes can follow
/// them.
std::string DescribeRest(std::size_t bytes) {
  constexpr std::size_t kMostBytes = 255;
  std::string descriptors;
  for (; bytes > 0; bytes -= std::min(bytes, kMostBytes)) {
    descriptors += FormatDescriptor(0, std::min(bytes, kMostBytes), "undocumented", "");
  }
  return descriptors;
}

const Vlr* FindVlr(const LasFile& las, std::string_view user, std::uint16_t id) {
  for (const Vlr& vlr : las.vlrs) {
    if (vlr.user == user && vlr.id == id) return &vlr;
  }
  return nullptr;
}

/// Appends a record to those that `head` has already.
void AppendVlr(const LasFile& las, const std::string& record, std::string* head) {
  const auto count = LoadLittleEndian<std::uint32_t>(head->data() + las::kVlrCountAt);
  std::size_t end = las.header_bytes;
  for (std::uint32_t i = 0; i < count; ++i) {
    end += las::kVlrHeaderBytes + LoadLittleEndian<std::uint16_t>(head->data() + end + 20);
  }
  head->insert(end, record);
  StoreLittleEndian(count + 1, head->data() + las::kVlrCountAt);
}

[[noreturn]] void FailFull(const LasFile& las) {
  throw InvalidInput("a record has no room for the covariance of its point",
                     FileLocation{las.path.string()});
}

/// Adds descriptors to the record of the extra bytes; creates this record if it does not exist.
void InsertDescriptors(const LasFile& las, const std::string& descriptors, std::string* head) {
  if (const Vlr* vlr = FindVlr(las, "LASF_Spec", las::kExtraBytesId)) {
    const std::size_t bytes = vlr->bytes + descriptors.size();
    if (bytes > kMostWord) FailFull(las);
    StoreLittleEndian(static_cast<std::uint16_t>(bytes), head->data() + vlr->at + 20);
    head->insert(vlr->at + las::kVlrHeaderBytes + vlr->bytes, descriptors);
    return;
  }
  AppendVlr(las, FormatExtraBytes(descriptors), head);
}

/// Returns the positions of the six elements in a record; adds the elements that the file lacks.
std::array<std::size_t, 6> PlaceCovariance(const LasFile& las, std::string* head,
                                           std::size_t* record_bytes) {
  std::array<std::size_t, 6> at{};
  std::string descriptors;
  for (std::size_t k = 0; k < kElements.size(); ++k) {
    const ExtraDimension* there = las.Find(kElements[k].name);
    if (there != nullptr && there->type == kFloat && there->scale == 1.0 && there->offset == 0.0) {
      at[k] = there->at;
      continue;
    }
    if (there != nullptr) {
      throw InvalidInput(std::string("the extra bytes ") + kElements[k].name +
                             " already exist but are not of type float; rename or remove them",
                         FileLocation{las.path.string()});
    }
    if (descriptors.empty()) descriptors = DescribeRest(*record_bytes - las.described_bytes);
    descriptors += FormatDescriptor(kFloat, 0, kElements[k].name, "of the coordinates, m^2");
    at[k] = *record_bytes;
    *record_bytes += kFloatBytes;
  }
  if (*record_bytes > kMostWord) FailFull(las);
  if (!descriptors.empty()) InsertDescriptors(las, descriptors, head);
  return at;
}

std::string BoresightContent(const Eigen::Vector3d& boresight_rad) {
  std::string content(las::kBoresightBytes, '\0');
  for (int i = 0; i < 3; ++i) {
    StoreLittleEndian(boresight_rad[i] * kDegPerRad, content.data() + 8 * i);
  }
  return content;
}

/// Returns the user and the number of a record whose content is no longer valid.
std::string SupersededName() {
  std::string name(las::kSupersededUser);
  name.resize(las::kRecordUserBytes, '\0');
  AppendLittleEndian(las::kSupersededId, name);
  return name;
}

bool IsLazName(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".laz";
}

/// Returns the header and records of the new file.
std::string MakeHead(const LasFile& las, const StripAdditions& additions,
                     std::optional<std::array<std::size_t, 6>>* covariance_at,
                     std::size_t* record_bytes) {
  std::string head = las.head;
  for (const Vlr& vlr : las.vlrs) {
    if (vlr.user == las::kIndexUser) {
      head.replace(vlr.at + las::kRecordUserAt, SupersededName().size(), SupersededName());
    }
  }
  std::string boresight;
  if (additions.boresight_rad) boresight = BoresightContent(*additions.boresight_rad);
  const Vlr* older = FindVlr(las, las::kBoresightUser, las::kBoresightId);
  if (older != nullptr && !boresight.empty()) {
    head.replace(older->at + las::kVlrHeaderBytes, boresight.size(), boresight);
  }
  if (additions.covariance) *covariance_at = PlaceCovariance(las, &head, record_bytes);
  if (older == nullptr && !boresight.empty()) {
    AppendVlr(las,
              FormatVlr(las::kBoresightUser, las::kBoresightId, "boresight r, p, y [deg, FRD]",
                        boresight),
              &head);
  }
  return head;
}

}  // namespace

LasWriter::LasWriter(const std::filesystem::path& file, LasFile las,
                     const StripAdditions& additions)
    : las_(std::move(las)), record_bytes_(las_.record_bytes), file_(file) {
  head_ = MakeHead(las_, additions, &covariance_at_, &record_bytes_);
  min_.setConstant(std::numeric_limits<double>::infinity());
  max_ = -min_;
  std::fill_n(head_.begin() + las::kSoftwareAt, kSoftwareBytes, '\0');
  std::memcpy(head_.data() + las::kSoftwareAt, kSoftware, std::strlen(kSoftware));
  if (IsLazName(file)) StartCompression();
  Store(las::kPointsAt, static_cast<std::uint32_t>(head_.size()));
  Store(las::kRecordBytesAt, static_cast<std::uint16_t>(record_bytes_));
  AppendBytes(head_);
}

void LasWriter::StartCompression() {
  const laz::Compression compression = laz::MakeCompression(las_.format, record_bytes_);
  AppendVlr(las_,
            FormatVlr(laz::Compression::kUser, laz::Compression::kId, "compression of the points",
                      laz::FormatCompression(compression)),
            &head_);
  head_[las::kFormatAt] = static_cast<char>(las_.format | las::kCompressedBit);
  compressed_.emplace(compression, head_.size());
}

void LasWriter::AppendBytes(std::string_view bytes) {
  file_.Append(bytes);
  end_ += bytes.size();
}

void LasWriter::Append(const StripCloud& points) {
  buffer_.clear();
  buffer_.reserve(points.size() * record_bytes_);
  for (std::size_t i = 0; i < points.size(); ++i) AppendRecord(points, i);
  if (compressed_) {
    compressed_->Append(buffer_);
    AppendBytes(compressed_->TakeBytes());
  } else {
    AppendBytes(buffer_);
  }
}

void LasWriter::AppendRecord(const StripCloud& points, std::size_t i) {
  const std::size_t begin = buffer_.size();
  buffer_.append(points.records, i * points.record_bytes, points.record_bytes);
  buffer_.resize(begin + record_bytes_);
  char* record = buffer_.data() + begin;
  StorePosition(points.p_c[i], record);
  if (covariance_at_) {
    for (std::size_t k = 0; k < kElements.size(); ++k) {
      const Eigen::Matrix3d& C = points.covariance_c_m2[i];
      StoreLittleEndian(static_cast<float>(C(kElements[k].row, kElements[k].column)),
                        record + (*covariance_at_)[k]);
    }
  }
  const int mask = las_.format >= 6 ? 15 : 7;
  const auto number = static_cast<std::size_t>(record[las::kReturnAt] & mask);
  if (number > 0) ++returns_[number - 1];
  ++written_;
}

void LasWriter::StorePosition(const Eigen::Vector3d& p_c, char* record) {
  for (int i = 0; i < 3; ++i) {
    const double steps = std::round((p_c[i] - las_.offset[i]) / las_.scale[i]);
    if (!(std::abs(steps) <= std::numeric_limits<std::int32_t>::max())) {
      throw InvalidInput("coordinate " + FormatDouble(p_c[i]) + " m of a new point lies outside " +
                             "what the scale factor " + FormatDouble(las_.scale[i]) +
                             " and the offset " + FormatDouble(las_.offset[i]) +
                             " of the file can hold; give the file a larger scale factor",
                         FileLocation{las_.path.string()});
    }
    StoreLittleEndian(static_cast<std::int32_t>(steps), record + 4 * i);
    const double stored = steps * las_.scale[i] + las_.offset[i];
    min_[i] = std::min(min_[i], stored);
    max_[i] = std::max(max_[i], stored);
  }
}

void LasWriter::FinishPoints() {
  if (!compressed_) return;
  compressed_->Finish();
  AppendBytes(compressed_->TakeBytes());
  std::string pointer;
  AppendLittleEndian(compressed_->table_at(), pointer);
  file_.Overwrite(head_.size(), pointer);
}

void LasWriter::CopyTail() {
  std::ifstream in(las_.path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(las_.tail_begin));
  std::string bytes;
  for (std::uint64_t left = las_.file_bytes - las_.tail_begin; left > 0; left -= bytes.size()) {
    bytes.resize(std::min<std::uint64_t>(left, kCopyBytes));
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (static_cast<std::size_t>(in.gcount()) != bytes.size()) {
      throw InvalidInput("file cannot be read after its points", FileLocation{las_.path.string()});
    }
    AppendBytes(bytes);
  }
}

/// Marks the copied indexes of the points as superseded. `tail_at` is the position of the copy.
void LasWriter::SupersedeIndexes(std::uint64_t tail_at) {
  for (const std::uint64_t at : las_.indexes_at) {
    file_.Overwrite(at - las_.tail_begin + tail_at + las::kRecordUserAt, SupersededName());
  }
}

void LasWriter::StoreCounts() {
  const bool legacy = las_.format < 6 && written_ <= std::numeric_limits<std::uint32_t>::max();
  Store(las::kLegacyCountAt, static_cast<std::uint32_t>(legacy ? written_ : 0));
  for (std::size_t k = 0; k < las::kLegacyReturns; ++k) {
    Store(las::kLegacyReturnsAt + 4 * k, static_cast<std::uint32_t>(legacy ? returns_[k] : 0));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    Store(las::kBoundsAt + 16 * i, written_ > 0 ? max_[axis] : 0.0);
    Store(las::kBoundsAt + 16 * i + 8, written_ > 0 ? min_[axis] : 0.0);
  }
  if (las_.minor < 4) return;
  Store(las::kCountAt, written_);
  for (std::size_t k = 0; k < las::kReturns; ++k) Store(las::kReturnsAt + 8 * k, returns_[k]);
}

/// Updates the positions at which the waveforms and the extended records begin. `tail_at` is the
/// position of the copied data.
void LasWriter::MoveTail(std::uint64_t tail_at) {
  const auto move = [&](std::size_t at) {
    const auto begin = LoadLittleEndian<std::uint64_t>(head_.data() + at);
    if (begin >= las_.tail_begin) Store(at, begin - las_.tail_begin + tail_at);
  };
  if (las_.has_waveform_field()) move(las::kWaveformAt);
  if (las_.minor >= 4) move(las::kEvlrAt);
}

void LasWriter::Finish() {
  FinishPoints();
  const std::uint64_t tail_at = end_;
  CopyTail();
  SupersedeIndexes(tail_at);
  StoreCounts();
  MoveTail(tail_at);
  file_.Overwrite(0, head_);
  file_.Publish();
}

}  // namespace dn::lidar_internal
