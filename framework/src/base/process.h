#pragma once

#include <cstddef>
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

/// What is set on top of an environment: names and values.
using EnvironmentChanges = std::vector<std::pair<std::string, std::string>>;

/// Starts this program anew with `arguments`, in a session of its own (Ctrl-C reaches the host alone, and there is no terminal
/// that it could wait for), killed by the kernel when the host ends for whatever reason. `environment` is set on top of the
/// host's own. `data_limit_mb`: how much memory of its own it and each process that it starts may map for writing (0: as much as
/// the host); it leaves no core dump then. The host must be single-threaded. Throws Error if no process can be started.
Child start_child(const std::vector<std::string>& arguments, const EnvironmentChanges& environment = {},
                  double data_limit_mb = 0);

/// Any program, started by a worker.
struct Program
{
    pid_t pid = -1;
    FileDescriptor output;  ///< Its standard output and error together, non-blocking.
};

/// The file that a shell would run for `name`: the name itself where it has a '/', else the absolute path of the first in PATH
/// that may be executed; empty if there is none.
std::string find_program(const std::string& name);

/// Starts a program, not through a shell, in `folder`, with nothing to read and none of this process's descriptors. It stays in
/// this process's group, so that whoever ends the group ends it too, and is killed by the kernel when this process ends. Throws
/// Error naming the program if it cannot be started.
Program start_program(const std::vector<std::string>& arguments, const EnvironmentChanges& environment,
                      const std::string& folder);

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
/// The same for the leader of a process group: whatever else is left of the group is killed first.
bool take_group_end(pid_t pid, ChildEnd& end);

/// "Segmentation fault (signal 11)".
std::string signal_text(int signal);

/// Splits what arrives in pieces into lines. Holds a bounded amount, whatever arrives.
class LineBuffer
{
  public:
    /// A line of more than `longest` bytes comes in pieces of that length.
    explicit LineBuffer(std::size_t longest = std::size_t{1} << 16U) : longest_(longest) {}

    /// Reads what is there without waiting, up to 1 MB at a time; false at the end of the stream.
    bool read_from(int fd);
    /// The next whole line, without its end; false if there is none.
    bool next(std::string& line);
    /// What came after the last line end.
    std::string rest() const { return buffer_.substr(start_); }

  private:
    std::size_t longest_;
    std::string buffer_;
    std::size_t start_ = 0;
};

/// Writes everything to a socket; never raises SIGPIPE. False if that fails; errno says why: EPIPE if the other side is gone.
bool send_all(int socket, std::string_view text);

}  // namespace fresco::host
