#include "input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gpsrecon/core/error.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

namespace gpsrecon::internal::io {
namespace {

// Bytes on their way in: owned, and never initialised twice.
struct Bytes {
  std::shared_ptr<char[]> data;
  std::size_t size = 0;
};

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ > STDERR_FILENO) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void fail_with_errno(const std::string& path, const char* action) {
  throw InputError(path + ": " + action + ": " + std::strerror(errno));
}

// Fills [begin, begin + size) as far as the input goes; returns the number of bytes read.
std::size_t read_fully(int fd, char* begin, std::size_t size, const std::string& path) {
  constexpr std::size_t largest_call = 1u << 30;  // the system call moves less than 2 GiB
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n = ::read(fd, begin + done, std::min(size - done, largest_call));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_with_errno(path, "cannot read");
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

// For pipes and devices, whose size is not known beforehand.
Bytes read_stream(int fd, std::size_t max_bytes, const std::string& path) {
  Bytes bytes;
  std::size_t capacity = 0;
  while (bytes.size == capacity && bytes.size < max_bytes) {
    capacity = std::min(max_bytes, std::max<std::size_t>(1u << 20, 2 * capacity));
    std::shared_ptr<char[]> larger(new char[capacity]);
    if (bytes.size > 0) std::memcpy(larger.get(), bytes.data.get(), bytes.size);
    bytes.data = std::move(larger);
    bytes.size += read_fully(fd, bytes.data.get() + bytes.size, capacity - bytes.size, path);
  }
  return bytes;
}

const Bytes& standard_input() {
  static const Bytes bytes = read_stream(STDIN_FILENO, std::numeric_limits<std::size_t>::max(), "-");
  return bytes;
}

}  // namespace

InputFile::InputFile(std::string path, std::size_t max_bytes) : path_(std::move(path)) {
  Bytes bytes;
  if (path_ == "-") {
    bytes = standard_input();
    file_size_ = bytes.size;
    bytes.size = std::min(bytes.size, max_bytes);
  } else {
    const Descriptor fd(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
    if (fd.get() < 0) fail_with_errno(path_, "cannot open");
    struct stat status;
    if (::fstat(fd.get(), &status) != 0) fail_with_errno(path_, "cannot open");
    if (S_ISDIR(status.st_mode)) throw InputError(path_ + ": is a directory, expected a file");
    if (S_ISREG(status.st_mode)) {
      file_size_ = static_cast<std::size_t>(status.st_size);
      bytes.size = std::min(file_size_, max_bytes);
      bytes.data.reset(new char[bytes.size]);
      const std::size_t found = read_fully(fd.get(), bytes.data.get(), bytes.size, path_);
      if (found < bytes.size) file_size_ = bytes.size = found;  // it shrank while it was read
    } else {
      bytes = read_stream(fd.get(), max_bytes, path_);
      file_size_ = bytes.size;
    }
  }
  if (bytes.size == 0) throw InputError(path_ + ": is empty");
  bytes_ = {bytes.data.get(), bytes.size};
  storage_ = std::move(bytes.data);
}

void InputFile::fail_at_line(std::size_t line, const std::string& message) const {
  throw InputError(path_ + ": line " + std::to_string(line) + ": " + message);
}

void InputFile::fail_at_byte(std::size_t byte, const std::string& message) const {
  throw InputError(path_ + ": byte " + std::to_string(byte) + ": " + message);
}

void InputFile::fail(const std::string& message) const {
  throw InputError(path_ + ": " + message);
}

std::string quote(std::string_view text) {
  constexpr std::size_t longest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, longest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > longest ? "...'" : "'");
}

}  // namespace gpsrecon::internal::io
