#include <dn/error.h>
#include <dn/geo/read_file.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
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

LineReader::LineReader(fs::path file) : file_(std::move(file)), in_(Open(file_, kMaxFileBytes)) {}

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
