#include <dn/geo/file_writer.h>
#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryEnding = ".part";

[[noreturn]] void ThrowErrno(const char* what, const fs::path& path) {
  throw fs::filesystem_error(what, path, std::error_code(errno, std::generic_category()));
}

/// Returns a hidden name in the directory of `path` that nobody can predict.
fs::path TemporarySibling(const fs::path& path) {
  std::uint64_t number = 0;
  if (::getrandom(&number, sizeof number, 0) != sizeof number)
    ThrowErrno("cannot get a random number", path);
  return path.parent_path() / ("." + path.filename().string() + "." + std::to_string(number) +
                               std::string(kTemporaryEnding));
}

int Open(const fs::path& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  if (fd < 0) ThrowErrno("cannot open", path);
  return fd;
}

/// Flushes the directory, which makes a rename in it durable.
void FlushDirectory(const fs::path& file) {
  const fs::path directory = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const int fd = Open(directory, O_RDONLY | O_DIRECTORY);
  const bool flushed = ::fsync(fd) == 0;
  const int error = errno;
  ::close(fd);
  errno = error;
  if (!flushed) ThrowErrno("cannot flush", directory);
}

}  // namespace

FileWriter::FileWriter(fs::path path)
    : path_(std::move(path)),
      temporary_(TemporarySibling(path_)),
      fd_(Open(temporary_, O_WRONLY | O_CREAT | O_EXCL)) {}

FileWriter::~FileWriter() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void FileWriter::Append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) ThrowErrno("cannot write", path_);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void FileWriter::Overwrite(std::uint64_t offset, std::string_view bytes) {
  if (::lseek(fd_, static_cast<off_t>(offset), SEEK_SET) < 0) ThrowErrno("cannot write", path_);
  Append(bytes);
  if (::lseek(fd_, 0, SEEK_END) < 0) ThrowErrno("cannot write", path_);
}

void FileWriter::Publish() {
  if (::fsync(fd_) != 0) ThrowErrno("cannot flush", path_);
  const int fd = fd_;
  fd_ = -1;
  // Some file systems report write errors only here.
  if (::close(fd) != 0) ThrowErrno("cannot close", path_);
  fs::rename(temporary_, path_);
  temporary_.clear();
  FlushDirectory(path_);
}

}  // namespace dn
