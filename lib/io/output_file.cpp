#include "output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gpsrecon/core/error.h>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace gpsrecon::internal {
namespace {

// Creates a file of a new name in `folder`. The name says nothing of the target's, whose length may be at the limit.
int create_temporary(const std::filesystem::path& folder, mode_t mode, std::string& name) {
  const std::string stem = ".gpsrecon-" + std::to_string(::getpid()) + "-";
  for (int n = 0;; ++n) {
    name = (folder / (stem + std::to_string(n) + ".tmp")).string();
    const int fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
}

}  // namespace

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path == "-") {
    file_ = stdout;
    return;
  }
  struct stat status;
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) {
    errno = EISDIR;
    fail("cannot write");
  }
  if (exists && ::access(path.c_str(), W_OK) != 0) fail("cannot write");
  int fd = -1;
  if (exists && !S_ISREG(status.st_mode)) {
    fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    std::error_code error;
    const std::filesystem::path resolved =
        exists ? std::filesystem::canonical(path, error) : std::filesystem::path(path);
    target_ = error ? path : resolved.string();
    const std::filesystem::path name = std::filesystem::path(target_).filename();
    if (name.empty() || name.string().size() > 255) {  // "folder/" or "", and what only the rename would find
      errno = name.empty() ? EISDIR : ENAMETOOLONG;
      fail("cannot write");
    }
    fd = create_temporary(std::filesystem::path(target_).parent_path(), 0666, temporary_);
    if (fd < 0) temporary_.clear();
    if (fd >= 0 && exists && ::fchmod(fd, status.st_mode & 0777) != 0) {
      // Not ours to insist on (another owner's file in a shared folder); the new file keeps the default permissions.
    }
  }
  if (fd < 0) fail("cannot write");
  file_ = ::fdopen(fd, "wb");
  if (file_ == nullptr) {
    ::close(fd);
    if (!temporary_.empty()) std::remove(temporary_.c_str());
    fail("cannot write");
  }
  std::setvbuf(file_, nullptr, _IOFBF, 1 << 18);
}

OutputFile::~OutputFile() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  if (!temporary_.empty()) std::remove(temporary_.c_str());
}

void OutputFile::write(const void* data, std::size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) fail("cannot write");
}

void OutputFile::commit() {
  if (std::fflush(file_) != 0 || std::ferror(file_) != 0) fail("cannot write");
  std::FILE* const file = std::exchange(file_, nullptr);
  if (file != stdout && std::fclose(file) != 0) fail("cannot write");
  if (target_.empty()) return;
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail("cannot replace");
  temporary_.clear();
}

void OutputFile::fail(const char* action) const {
  throw OutputError(path_ + ": " + action + ": " + std::strerror(errno));
}

}  // namespace gpsrecon::internal
