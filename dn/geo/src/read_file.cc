#include <dn/error.h>
#include <dn/geo/read_file.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr std::size_t kSampleBytes = 4096;
constexpr std::size_t kMostLineBytes = std::size_t{1} << 16;

const char* KindName(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::fifo:
      return "a named pipe";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::character:
    case fs::file_type::block:
      return "a device";
    default:
      return "of an unknown kind";
  }
}

std::ifstream Open(const fs::path& file, std::uintmax_t max_bytes) {
  ExpectRegularFile(file, max_bytes);
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw InvalidInput("file cannot be opened for reading; check its permissions", {file.string()});
  }
  return in;
}

/// Appends up to a chunk to `content`; returns false at the end of the file.
bool AppendChunk(std::ifstream& in, const fs::path& file, std::string& content) {
  const std::size_t size = content.size();
  content.resize(size + kChunkBytes);
  in.read(content.data() + size, kChunkBytes);
  content.resize(size + static_cast<std::size_t>(in.gcount()));
  if (in.bad()) throw InvalidInput("file cannot be read", {file.string()});
  return content.size() > size;
}

}  // namespace

void ExpectRegularFile(const fs::path& file, std::uintmax_t max_bytes) {
  const FileLocation where{file.string()};
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) throw InvalidInput("file does not exist", where);
  if (status.type() == fs::file_type::none) {
    throw InvalidInput("file cannot be reached: " + error.message(), where);
  }
  if (status.type() != fs::file_type::regular) {
    throw InvalidInput(std::string("this is ") + KindName(status.type()) + ", not a regular file",
                       where);
  }
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (!error && bytes > max_bytes) {
    throw InvalidInput("file has " + std::to_string(bytes) + " bytes, at most " +
                           std::to_string(max_bytes) + " are read",
                       where);
  }
}

bool IsCircularLink(const fs::path& path) {
  std::error_code error;
  const bool followed = fs::exists(path, error);
  return !followed && error == std::errc::too_many_symbolic_link_levels;
}

std::string ReadWholeFile(const fs::path& file, std::uintmax_t max_bytes) {
  std::ifstream in = Open(file, max_bytes);
  std::string content;
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (!error) content.reserve(bytes + kChunkBytes);
  while (AppendChunk(in, file, content)) {
  }
  return content;
}

std::string ReadBeginning(const fs::path& file, std::size_t bytes) {
  std::ifstream in = Open(file, UINTMAX_MAX);
  std::string text(bytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(bytes));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

bool IsUtf16(std::string_view beginning) {
  const bool marked = beginning.starts_with("\xFF\xFE") || beginning.starts_with("\xFE\xFF");
  const std::size_t pairs = beginning.size() / 2;
  std::size_t zeros[2] = {0, 0};
  for (std::size_t i = 0; i < 2 * pairs; ++i) zeros[i % 2] += beginning[i] == '\0' ? 1 : 0;
  // The high bytes of ASCII characters are 0, and the low bytes are not.
  const std::size_t least = marked ? pairs / 2 : pairs;
  return pairs >= 4 &&
         ((zeros[0] >= least && zeros[1] == 0) || (zeros[1] >= least && zeros[0] == 0));
}

bool IsBinary(std::string_view beginning) {
  if (IsUtf16(beginning)) return false;
  constexpr std::size_t kLeastShare = 10;
  const auto high = std::count_if(beginning.begin(), beginning.end(),
                                  [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
  return beginning.find('\0') != std::string_view::npos ||
         static_cast<std::size_t>(high) > beginning.size() / kLeastShare;
}

bool IsBinaryFile(const fs::path& file) { return IsBinary(ReadBeginning(file, kSampleBytes)); }

LineReader::LineReader(fs::path file) : file_(std::move(file)), in_(Open(file_, kMaxFileBytes)) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  ReadMore();
  if (IsUtf16(std::string_view(buffer_).substr(0, kSampleBytes))) {
    throw InvalidInput("file is text in UTF-16; save it as UTF-8 or ASCII", {file_.string()});
  }
  if (buffer_.starts_with(kByteOrderMark)) begin_ = kByteOrderMark.size();
}

bool LineReader::ReadMore() {
  buffer_.erase(0, begin_);
  begin_ = 0;
  if (buffer_.size() > kMostLineBytes) {
    throw InvalidInput("line is longer than " + std::to_string(kMostLineBytes) +
                           " bytes: this is not a text file of numbers",
                       {file_.string(), line_ + 1});
  }
  return AppendChunk(in_, file_, buffer_);
}

bool LineReader::Next(std::string_view* line) {
  std::size_t scanned = begin_;
  std::size_t end = 0;
  while ((end = buffer_.find('\n', scanned)) == std::string::npos) {
    const std::size_t unread = buffer_.size() - begin_;
    if (!ReadMore()) {
      if (buffer_.empty()) return false;
      end = buffer_.size();
      break;
    }
    scanned = begin_ + unread;
  }
  *line = std::string_view(buffer_).substr(begin_, end - begin_);
  begin_ = std::min(end + 1, buffer_.size());
  ++line_;
  return true;
}

}  // namespace dn
