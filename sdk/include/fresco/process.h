#pragma once

#include <fresco/file_access.h>

#include <cstddef>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

/// \file Running other programs: for the host, which runs every stage in a process of its own, and for stages that run a program.

namespace fresco
{

/// Variables to set on top of an environment: names and values.
using EnvironmentChanges = std::vector<std::pair<std::string, std::string>>;

/// Descriptor number of ProcessStart::channel within the process.
inline constexpr int child_channel = 3;

struct ProcessStart
{
    std::string file;                    ///< The program; no search in PATH.
    std::vector<std::string> arguments;  ///< Its own name first.
    EnvironmentChanges environment{};    ///< On top of this process's own.
    std::string folder{};                ///< Folder where it starts; empty: here.
    int channel = -1;                    ///< Descriptor that it gets as child_channel, or -1.
    /// It cannot be reached by Ctrl-C, nor wait for a terminal. Otherwise it stays in this process's group: whoever ends the
    /// group ends it too.
    bool own_session = false;
    double data_limit_mb =
        0;  ///< Memory of its own that it and each process it starts may map; it leaves no core dump. 0: no limit.
};

struct Process
{
    pid_t pid = -1;
    FileDescriptor output;  ///< Its standard output and error together, non-blocking.
};

/// Starts a program, not through a shell, with nothing to read and no other descriptor of this process. The kernel kills it when
/// this process ends for whatever reason. Throws Error naming the program if it cannot be started.
Process start_process(const ProcessStart& start);

/// The file that a shell would run for `name`: the name itself where it has a '/', else the absolute path of the first in PATH
/// that may be executed; empty if there is none.
std::string find_program(const std::string& name);

/// How a process ended.
struct ProcessEnd
{
    int exit_code = -1;  ///< -1 if a signal ended it.
    int signal = 0;
    double peak_memory_mb = 0;
};
/// Takes the end of `pid` if it has ended; does not wait.
bool take_end(pid_t pid, ProcessEnd& end);
/// take_end for the leader of a process group: the rest of the group is killed first.
bool take_group_end(pid_t pid, ProcessEnd& end);

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
    /// Text after the last line end.
    std::string rest() const { return buffer_.substr(start_); }

  private:
    std::size_t longest_;
    std::string buffer_;
    std::size_t start_ = 0;
};

/// The children of a process.
std::vector<pid_t> children_of(pid_t pid);
void signal_descendants(pid_t pid, int number);
/// From now on whatever descends from this process stays below it, also when its parent ends.
void adopt_orphans();
/// Kills all that descends from this process, but for the children `spared` and what they started, and takes their ends: for one
/// that adopts orphans.
void end_descendants(const std::vector<pid_t>& spared = {});

}  // namespace fresco
