#include <dn/flight/atomic_file.h>
#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

#include "temporary_name.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryEnding = ".part";

[[noreturn]] void ThrowErrno(const char* what, const fs::path& path) {
  throw fs::filesystem_error(what, path, std::error_code(errno, std::generic_category()));
}

/// An open file descriptor, closed at the end of its scope.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (fd_ < 0) ThrowErrno("cannot open", path);
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void Write(std::string_view content, const fs::path& path) const {
    while (!content.empty()) {
      const ssize_t written = ::write(fd_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) ThrowErrno("cannot write", path);
      content.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void Flush(const fs::path& path) const {
    if (::fsync(fd_) != 0) ThrowErrno("cannot flush", path);
  }
  /// A file system may report a write error only here.
  void Close(const fs::path& path) {
    const int fd = fd_;
    fd_ = -1;
    if (::close(fd) != 0) ThrowErrno("cannot close", path);
  }

 private:
  int fd_;
};

/// Makes a rename in the directory durable.
void FlushDirectory(const fs::path& file) {
  const fs::path directory = file.has_parent_path() ? file.parent_path() : fs::path(".");
  Descriptor(directory, O_RDONLY | O_DIRECTORY).Flush(directory);
}

}  // namespace

fs::path internal::TemporarySibling(const fs::path& path) {
  std::uint64_t number = 0;
  if (::getrandom(&number, sizeof number, 0) != sizeof number) ThrowErrno("no random number", path);
  return path.parent_path() / ("." + path.filename().string() + "." + std::to_string(number) +
                               std::string(kTemporaryEnding));
}

void WriteFileAtomically(const fs::path& path, std::string_view content) {
  const fs::path temporary = internal::TemporarySibling(path);
  Descriptor file(temporary, O_WRONLY | O_CREAT | O_EXCL);
  try {
    file.Write(content, path);
    file.Flush(path);
    file.Close(path);
    fs::rename(temporary, path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  FlushDirectory(path);
}

}  // namespace dn
