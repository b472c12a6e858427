#pragma once

#include <string>
#include <string_view>
#include <sys/types.h>
#include <utility>
#include <vector>

namespace fresco::host
{

/// Owns a file descriptor; -1 = none.
class FileDescriptor
{
  public:
    FileDescriptor() = default;
    explicit FileDescriptor(int fd) : fd_(fd) {}
    ~FileDescriptor() { reset(); }
    FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept;
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;

    int get() const { return fd_; }
    bool valid() const { return fd_ >= 0; }
    void reset();

  private:
    int fd_ = -1;
};

/// A process of this same program, started to do one job.
struct Child
{
    pid_t pid = -1;
    FileDescriptor channel;  ///< The child's descriptor 3, non-blocking: JSON lines to the host.
    FileDescriptor output;   ///< The child's standard output and error together, non-blocking.
};

/// Descriptor number of the channel within the child.
inline constexpr int child_channel = 3;

/// Starts this program anew with `arguments`, in a process group of its own (Ctrl-C reaches the host alone), killed by the kernel
/// when the host ends for whatever reason. `environment` is set on top of the host's own. The host must be single-threaded.
/// Throws Error if no process can be started.
Child start_child(const std::vector<std::string>& arguments,
                  const std::vector<std::pair<std::string, std::string>>& environment = {});

/// How a process ended.
struct ChildEnd
{
    int exit_code = -1;  ///< -1 if a signal ended it.
    int signal = 0;
    double peak_memory_mb = 0;
    double cpu_seconds = 0;
};
/// Takes the end of `pid` if it has ended; does not wait.
bool take_end(pid_t pid, ChildEnd& end);

/// "Segmentation fault (signal 11)".
std::string signal_text(int signal);

/// Splits what arrives in pieces into lines.
class LineBuffer
{
  public:
    /// Reads all that is there without waiting; false at the end of the stream.
    bool read_from(int fd);
    /// The next whole line, without its end; false if there is none.
    bool next(std::string& line);
    /// What came after the last line end.
    std::string rest() const { return buffer_.substr(start_); }

  private:
    std::string buffer_;
    std::size_t start_ = 0;
};

/// Writes everything to a socket; never raises SIGPIPE. False if the other side is gone.
bool send_all(int socket, std::string_view text);

}  // namespace fresco::host
