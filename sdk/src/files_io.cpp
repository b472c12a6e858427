#include <fresco/copy_file.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/write_pieces.h>

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <functional>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace fresco
{
namespace
{

std::string cause()
{
    return std::generic_category().message(errno);
}

/// Closes on every way out.
class Descriptor
{
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor()
    {
        if (fd_ >= 0)
            ::close(fd_);
    }
    Descriptor(Descriptor&& other) noexcept : fd_(other.release()) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    Descriptor& operator=(Descriptor&& other) noexcept
    {
        std::swap(fd_, other.fd_);
        return *this;
    }
    int get() const { return fd_; }
    int release() { return std::exchange(fd_, -1); }

  private:
    int fd_;
};

std::vector<std::byte> read_all(const std::filesystem::path& file, std::size_t limit_bytes)
{
    const auto status = std::filesystem::status(file);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw Error(file.string() + ": is not a regular file");
    const Descriptor input(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
    if (input.get() < 0)
        throw MissingInput(file.string() + ": cannot be opened: " + cause());
    const auto size = std::filesystem::file_size(file);
    if (size > limit_bytes)
        throw Error(fmt::format("{}: has {} bytes; at most {} are accepted", file.string(), size, limit_bytes));
    std::vector<std::byte> bytes(size);
    std::size_t done = 0;
    while (done < bytes.size())
    {
        const ssize_t count = ::read(input.get(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            throw MissingInput(file.string() + ": reading failed: " + cause());
        if (count == 0)
            throw Error(file.string() + ": became shorter while it was read");
        done += static_cast<std::size_t>(count);
    }
    return bytes;
}

void write_all(int fd, std::span<const std::byte> bytes, const std::filesystem::path& file)
{
    while (!bytes.empty())
    {
        const ssize_t count = ::write(fd, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            throw Error(file.string() + ": cannot be written: " + cause());
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
}

void make_durable(int fd, const std::filesystem::path& file)
{
    if (::fsync(fd) != 0)
        throw Error(file.string() + ": cannot be written: " + cause());
}

/// To find that a temporary file is still the one that was locked.
constexpr int most_tries = 100;

enum class Lock
{
    held,
    /// The file system has none, so that nobody holds one.
    unknown_here,
    refused
};

Lock lock(int fd)
{
    while (::flock(fd, LOCK_EX) != 0)
    {
        if (errno == EOPNOTSUPP || errno == ENOSYS || errno == EINVAL)
            return Lock::unknown_here;
        if (errno != EINTR)
            return Lock::refused;
    }
    return Lock::held;
}

/// Whether `path` still names the open file: another writer may have renamed or removed it before its lock became ours.
bool names(const std::filesystem::path& path, int fd)
{
    struct stat there = {};
    struct stat here = {};
    return ::stat(path.c_str(), &there) == 0 && ::fstat(fd, &here) == 0 && there.st_ino == here.st_ino &&
           there.st_dev == here.st_dev;
}

int open_to_write(const std::filesystem::path& path)
{
    return ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
}

/// `shared` opened and locked, or nothing where this process needs a name of its own: the file system knows no locks, the name
/// is another user's, or other writers of the same file were always faster. A file under that name is never removed here while
/// somebody may hold it.
Descriptor open_shared(const std::filesystem::path& file, const std::filesystem::path& shared)
{
    for (int tries = 0; tries < most_tries; ++tries)
    {
        Descriptor output(open_to_write(shared));
        if (output.get() < 0)
        {
            if (errno == EACCES || errno == EPERM || errno == ELOOP)
                return Descriptor(-1);
            // On layered file systems also when the name was renamed away at this moment.
            if (errno == ENOENT && std::filesystem::is_directory(shared.parent_path().empty() ? "." : shared.parent_path()))
                continue;
            throw Error(file.string() + ": cannot be written: " + cause());
        }
        const Lock state = lock(output.get());
        if (state == Lock::unknown_here)
            ::unlink(shared.c_str());
        if (state != Lock::held)
            return Descriptor(-1);
        if (names(shared, output.get()))
            return output;
    }
    return Descriptor(-1);
}

/// The file that becomes `file`, open, empty and ours alone; `temporary` is set to its path. Its name is the same every time, so
/// that what a killed process left behind is used by the next one that writes the same file.
int open_temporary(const std::filesystem::path& file, std::filesystem::path& temporary)
{
    temporary = file;
    temporary += ".tmp";
    Descriptor output = open_shared(file, temporary);
    if (output.get() < 0)
    {
        static std::atomic<unsigned> counter{0};
        temporary += fmt::format("-{}-{}", ::getpid(), counter++);
        output = Descriptor(open_to_write(temporary));
        if (output.get() < 0)
            throw Error(file.string() + ": cannot be written: " + cause());
    }
    if (::ftruncate(output.get(), 0) != 0)
        throw Error(file.string() + ": cannot be written: " + cause());
    return output.release();
}

/// `file` with what `fill` writes to the descriptor that it is given.
void write_whole(const std::filesystem::path& file, const std::function<void(int)>& fill,
                 const std::function<void()>& written = {})
{
    std::filesystem::path temporary;
    const Descriptor output(open_temporary(file, temporary));
    try
    {
        fill(output.get());
        make_durable(output.get(), file);
        if (written)
            written();
        if (::rename(temporary.c_str(), file.c_str()) != 0)
            throw Error(file.string() + ": cannot be written: " + cause());
    }
    catch (...)
    {
        ::unlink(temporary.c_str());
        throw;
    }
}

}  // namespace

std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t limit_bytes)
{
    return read_all(file, limit_bytes);
}

std::string read_text_file(const std::filesystem::path& file, std::size_t limit_bytes)
{
    const auto bytes = read_all(file, limit_bytes);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void write_file(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    write_pieces(file, std::span(&bytes, 1));
}

void write_pieces(const std::filesystem::path& file, std::span<const std::span<const std::byte>> pieces)
{
    write_whole(file,
                [&](int output)
                {
                    for (const auto bytes : pieces)
                        write_all(output, bytes, file);
                });
}

void copy_file(const std::filesystem::path& from, const std::filesystem::path& to, const std::function<void()>& written)
{
    const Descriptor input(::open(from.c_str(), O_RDONLY | O_CLOEXEC));
    if (input.get() < 0)
        throw Error(from.string() + ": cannot be opened: " + cause());
    const auto fill = [&](int output)
    {
        std::vector<std::byte> buffer(std::size_t{1} << 20U);
        for (;;)
        {
            const ssize_t count = ::read(input.get(), buffer.data(), buffer.size());
            if (count < 0 && errno == EINTR)
                continue;
            if (count < 0)
                throw Error(from.string() + ": cannot be read: " + cause());
            if (count == 0)
                return;
            write_all(output, std::span(buffer).first(static_cast<std::size_t>(count)), to);
        }
    };
    write_whole(to, fill, written);
}

void write_file(const std::filesystem::path& file, std::string_view text)
{
    write_file(file, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace fresco
