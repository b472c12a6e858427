#include "download.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/process.h>
#include <fresco/weights/sha256.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <iterator>
#include <poll.h>
#include <sstream>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace fresco::weights
{
namespace
{

namespace fs = std::filesystem;

std::string cause()
{
    return std::generic_category().message(errno);
}

/// Result of curl.
struct Fetched
{
    int exit_code = 0;
    std::string status;  ///< HTTP status: "206"; "000" without an answer.
};

constexpr int no_ranges = 33;
constexpr int too_large = 63;
constexpr int not_found_program = 127;

/// Appends to `part` what it lacks. The user's curl settings are not read: they could write elsewhere. A server that sends less
/// than 1 kB/s for a minute counts as gone.
Fetched run_curl(const std::string& url, const fs::path& part, std::uint64_t most_bytes)
{
    std::istringstream words("curl --disable --fail --location --proto =http,https --globoff --show-error --retry 3 "
                             "--connect-timeout 30 --speed-limit 1000 --speed-time 60 --continue-at -");
    ProcessStart start{.file = find_program("curl"), .arguments = {std::istream_iterator<std::string>(words), {}}};
    if (start.file.empty())
        return {not_found_program, ""};
    auto& arguments = start.arguments;
    constexpr std::string_view mark = "http_code:";
    arguments.insert(arguments.end(), {"--write-out", std::string(mark) + "%{http_code}\\n"});
    arguments.insert(arguments.end(), {"--proto-redir", url.starts_with("https:") ? "=https" : "=http,https"});
    arguments.insert(arguments.end(), {"--max-filesize", std::to_string(most_bytes)});
    if (isatty(STDERR_FILENO) == 1)
        arguments.insert(arguments.end(), {"--progress-bar", "--stderr", "/dev/tty"});
    else
        arguments.emplace_back("--silent");
    arguments.insert(arguments.end(), {"--output", part.string(), "--url", url});

    const Process curl = start_process(start);
    Fetched result;
    LineBuffer output;
    ProcessEnd end;
    for (bool has_ended = false; !has_ended;)
    {
        pollfd descriptor{curl.output.get(), POLLIN, 0};
        poll(&descriptor, 1, 100);
        has_ended = take_end(curl.pid, end);
        output.read_from(curl.output.get());
        for (std::string line; output.next(line);)
            if (line.starts_with(mark))
                result.status = line.substr(mark.size());
            else
                std::fprintf(stderr, "%s\n", line.c_str());
        // Before 8.4, curl's own limit counts only where the server says how much it sends.
        if (!has_ended && fs::file_size(part) > most_bytes)
            kill(curl.pid, SIGKILL);
    }
    result.exit_code = end.exit_code;
    return result;
}

/// The unfinished file, locked as long as this lives.
class Part
{
  public:
    explicit Part(fs::path path)
        : path_(std::move(path)),
          file_(uninterrupted([&] { return open(path_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666); }))
    {
        if (!file_.valid())
            throw Error(path_.string() + ": cannot be written: " + cause());
        if (uninterrupted([&] { return flock(file_.get(), LOCK_EX | LOCK_NB); }) != 0)
            throw Error(path_.string() + (errno == EWOULDBLOCK ? ": another program is fetching this file now; wait for it"
                                                               : ": cannot be locked: " + cause()));
    }
    const fs::path& path() const { return path_; }
    std::uintmax_t size() const { return fs::file_size(path_); }
    void clear() const
    {
        if (uninterrupted([&] { return ftruncate(file_.get(), 0); }) != 0)
            throw Error(path_.string() + ": cannot be written: " + cause());
    }
    void publish(const fs::path& to) const
    {
        if (uninterrupted([&] { return fsync(file_.get()); }) != 0 || std::rename(path_.c_str(), to.c_str()) != 0)
            throw Error(to.string() + ": cannot be written: " + cause());
    }

  private:
    fs::path path_;
    FileDescriptor file_;
};

[[noreturn]] void not_fetched(const std::string& url, const Fetched& fetched, const Part& part)
{
    const bool begun = part.size() > 0;
    if (!begun)
        fs::remove(part.path());
    if (fetched.exit_code == not_found_program)
        throw Error("the program curl is not installed; `apt-get install curl`, or fetch " + url + " yourself");
    const bool answered = !fetched.status.empty() && fetched.status != "000";
    throw Error(url + ": not fetched (curl ended with " + std::to_string(fetched.exit_code) +
                (answered ? ", the server answered " + fetched.status : "") + "); " +
                (begun ? "the partial download is kept in " + part.path().string() + ": run again to resume"
                       : "check the URL and the connection"));
}

void check_arguments(const Download& what)
{
    if (!what.url.starts_with("https://") && !what.url.starts_with("http://"))
        throw Error("'" + what.url + "' is not a URL that begins with https:// or http://");
    if (!is_sha256_prefix(what.sha256_prefix))
        throw Error("'" + what.sha256_prefix + "' is not the beginning of a SHA-256; use 8 to 64 hexadecimal digits");
}

}  // namespace

bool download(const Download& what)
{
    check_arguments(what);
    if (fs::exists(what.to))
    {
        const std::string hash = sha256_of_file(what.to);
        if (has_sha256_prefix(hash, what.sha256_prefix))
            return false;
        throw Error(what.to.string() + ": already exists, but its SHA-256 is " + hash + ", which does not begin with " +
                    what.sha256_prefix + "; remove it, or fetch to another place with --to");
    }
    if (what.to.has_parent_path())
        fs::create_directories(what.to.parent_path());
    fs::path beside = what.to;
    beside += ".fresco-part";
    const Part part(beside);

    bool resumed = part.size() > 0;
    for (;;)
    {
        // All of it may have arrived before the last call was ended; a server has nothing more to send then.
        std::string hash = resumed ? sha256_of_file(part.path()) : "";
        if (!has_sha256_prefix(hash, what.sha256_prefix))
        {
            const Fetched fetched = run_curl(what.url, part.path(), what.most_bytes);
            if (fetched.exit_code == too_large || part.size() >= what.most_bytes)
            {
                fs::remove(part.path());
                throw Error(what.url + ": the server sends more than " + std::to_string(what.most_bytes) +
                            " bytes, more than the expected file has; check --url");
            }
            const bool cannot_resume = fetched.exit_code == no_ranges || fetched.status == "416";
            if (fetched.exit_code != 0 && !(resumed && cannot_resume))
                not_fetched(what.url, fetched, part);
            hash = fetched.exit_code == 0 ? sha256_of_file(part.path()) : "";
        }
        if (has_sha256_prefix(hash, what.sha256_prefix))
        {
            part.publish(what.to);
            return true;
        }
        if (!resumed)
        {
            fs::remove(part.path());
            throw Error(what.url + ": what arrived has the SHA-256 " + hash + ", which does not begin with " +
                        what.sha256_prefix + "; it was removed");
        }
        // The beginning may be that of another file, or the server cannot go on: once more from the start.
        part.clear();
        resumed = false;
    }
}

}  // namespace fresco::weights
