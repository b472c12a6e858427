#define XXH_INLINE_ALL
#include <xxhash.h>

#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/fs.h>
#include <list>
#include <memory>
#include <set>
#include <sys/ioctl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace fresco
{
namespace
{

constexpr std::size_t checksum_digits = 32;

std::span<const std::byte> bytes_of(std::string_view text)
{
    return std::as_bytes(std::span(text.data(), text.size()));
}

std::string text_of(const std::vector<std::byte>& bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string cause()
{
    return std::generic_category().message(errno);
}

/// Reads what is there, up to the size of `bytes`; 0 at the end. Throws `Failure`.
template <class Failure = MissingInput>
std::size_t read_some(const FileDescriptor& input, std::span<std::byte> bytes, const std::filesystem::path& file)
{
    const ssize_t count = uninterrupted([&] { return ::read(input.get(), bytes.data(), bytes.size()); });
    if (count < 0)
        throw Failure(file.string() + ": reading failed: " + cause());
    return static_cast<std::size_t>(count);
}

/// A regular file that was opened, and its size.
std::pair<FileDescriptor, std::size_t> opened_file(const std::filesystem::path& file, FileDescriptor input)
{
    struct stat status = {};
    if (!input.valid() || ::fstat(input.get(), &status) != 0)
        throw MissingInput(file.string() + ": cannot be opened: " + cause());
    if (!S_ISREG(status.st_mode))
        throw Error(file.string() + ": is not a regular file");
    return {std::move(input), static_cast<std::size_t>(status.st_size)};
}

void write_all(int fd, std::span<const std::byte> bytes, const std::filesystem::path& file)
{
    while (!bytes.empty())
    {
        const ssize_t count = uninterrupted([&] { return ::write(fd, bytes.data(), bytes.size()); });
        if (count < 0)
            throw Error(file.string() + ": cannot be written: " + cause());
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
}

/// 128 random bits: a name that begins so is nobody else's.
std::string temporary_name()
{
    std::array<unsigned char, 16> bits{};
    if (::getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size()))
        throw Error("no random numbers: " + cause());
    return fmt::format("{}{:02x}", temporary_file_prefix, fmt::join(bits, ""));
}

/// Draft of `file`. It has no name while it is written, if the file system can do that: a killed process leaves
/// nothing behind.
class Draft
{
  public:
    explicit Draft(const std::filesystem::path& file)
        : file_(file), folder_(file.has_parent_path() ? file.parent_path() : "."),
          opened_folder_(open_file(folder_, O_PATH | O_DIRECTORY))
    {
        if (!opened_folder_.valid())
            fail();
        output_ = open_here(".", O_TMPFILE | O_WRONLY);
        if (output_.valid())
            return;
        name_ = temporary_name();
        output_ = open_here(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL);
        if (output_.valid())
            return;
        name_.clear();
        fail();
    }
    Draft(const Draft&) = delete;
    Draft& operator=(const Draft&) = delete;
    ~Draft()
    {
        if (!name_.empty())
            ::unlinkat(opened_folder_.get(), name_.c_str(), 0);
    }

    int descriptor() const { return output_.get(); }
    const std::filesystem::path& folder() const { return folder_; }
    dev_t file_system() const
    {
        struct stat status = {};
        if (::fstat(output_.get(), &status) != 0)
            fail();
        return status.st_dev;
    }
    void make_durable() const
    {
        if (uninterrupted([&] { return ::fsync(output_.get()); }) != 0)
            fail();
    }
    void flush_file_system() const
    {
        if (uninterrupted([&] { return ::syncfs(output_.get()); }) != 0)
            fail();
    }
    void put_in_place()
    {
        if (name_.empty())
        {
            // A link never replaces a file, so it gets a name first.
            const std::string named = temporary_name();
            const std::string unnamed = fmt::format("/proc/self/fd/{}", output_.get());
            if (::linkat(AT_FDCWD, unnamed.c_str(), opened_folder_.get(), named.c_str(), AT_SYMLINK_FOLLOW) != 0)
                fail();
            name_ = named;
        }
        if (::renameat(opened_folder_.get(), name_.c_str(), opened_folder_.get(), file_.filename().c_str()) != 0)
        {
            const int cause_before = errno;
            PathEntry(file_).check_kind(false);
            errno = cause_before;
            fail();
        }
        name_.clear();
    }
    void make_name_durable() const
    {
        const FileDescriptor folder = open_here(".", O_RDONLY | O_DIRECTORY);
        if (!folder.valid() || uninterrupted([&] { return ::fsync(folder.get()); }) != 0)
            fail();
    }

  private:
    [[noreturn]] void fail() const { throw Error(file_.string() + ": cannot be written: " + detail::cause_of(errno, file_)); }
    FileDescriptor open_here(const char* name, int flags) const
    {
        return FileDescriptor(uninterrupted([&] { return ::openat(opened_folder_.get(), name, flags | O_CLOEXEC, 0666); }));
    }

    std::filesystem::path file_;
    std::filesystem::path folder_;
    FileDescriptor opened_folder_;
    FileDescriptor output_;
    std::string name_;
};

/// Writes to `output`, which becomes `to`.
void fill_from(const std::filesystem::path& from, int output, const std::filesystem::path& to)
{
    const FileDescriptor input = open_file(from, O_RDONLY);
    if (!input.valid())
        throw Error(from.string() + ": cannot be opened: " + cause());
    // File systems that share blocks between files take no time and no space for it.
    if (::ioctl(output, FICLONE, input.get()) == 0)
        return;
    std::vector<std::byte> buffer(std::size_t{1} << 20U);
    while (const std::size_t count = read_some<Error>(input, buffer, from))
        write_all(output, std::span(buffer).first(count), to);
}

/// Puts the data of all drafts on the disk: a few one by one, many by one call per file system.
void flush(const std::list<Draft>& drafts)
{
    constexpr std::size_t many = 8;
    std::set<dev_t> flushed;
    for (const Draft& draft : drafts)
        if (drafts.size() < many)
            draft.make_durable();
        else if (flushed.insert(draft.file_system()).second)
            draft.flush_file_system();
}

}  // namespace

std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t limit_bytes)
{
    const auto [input, size] = opened_file(file, open_file(file, O_RDONLY));
    if (size > limit_bytes)
        throw Error(fmt::format("{}: has {} bytes; at most {} are accepted", file.string(), size, limit_bytes));
    std::vector<std::byte> bytes(size);
    for (std::span rest(bytes); !rest.empty();)
    {
        const std::size_t count = read_some(input, rest, file);
        if (count == 0)
            throw Error(file.string() + ": became shorter while it was read");
        rest = rest.subspan(count);
    }
    return bytes;
}

std::string read_text_file(const std::filesystem::path& file, std::size_t limit_bytes)
{
    return text_of(read_file(file, limit_bytes));
}

void write_file(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    Draft draft(file);
    write_all(draft.descriptor(), bytes, file);
    draft.put_in_place();
}

void write_file(const std::filesystem::path& file, std::string_view text)
{
    write_file(file, bytes_of(text));
}

void write_durable_file(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    write_durable_file(file, std::span(&bytes, 1));
}

void write_durable_file(const std::filesystem::path& file, std::string_view text)
{
    write_durable_file(file, bytes_of(text));
}

void write_durable_file(const std::filesystem::path& file, std::span<const std::span<const std::byte>> pieces)
{
    Draft draft(file);
    for (const auto bytes : pieces)
        write_all(draft.descriptor(), bytes, file);
    draft.make_durable();
    draft.put_in_place();
    draft.make_name_durable();
}

void write_checked(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    const std::string checksum = content_hash(bytes);
    const std::array pieces{bytes, bytes_of(checksum)};
    write_durable_file(file, pieces);
}

void write_checked(const std::filesystem::path& file, std::string_view text)
{
    write_checked(file, bytes_of(text));
}

std::vector<std::byte> read_checked(const std::filesystem::path& file)
{
    std::vector<std::byte> bytes = read_file(file);
    const std::size_t size = bytes.size() - std::min(bytes.size(), checksum_digits);
    const std::span all(bytes);
    const std::string checksum = content_hash(all.first(size));
    if (!std::ranges::equal(all.subspan(size), bytes_of(checksum)))
        throw Error(file.string() + ": is damaged: its bytes do not fit its checksum");
    bytes.resize(size);
    return bytes;
}

std::string read_checked_text(const std::filesystem::path& file)
{
    return text_of(read_checked(file));
}

void copy_files(std::span<const FileCopy> copies, const std::function<void()>& written)
{
    if (copies.empty())
        return;
    std::list<Draft> drafts;
    for (const FileCopy& copy : copies)
        fill_from(copy.from, drafts.emplace_back(copy.to).descriptor(), copy.to);
    flush(drafts);
    if (written)
        written();
    for (Draft& draft : drafts)
        draft.put_in_place();
    std::set<std::filesystem::path> folders;
    for (const Draft& draft : drafts)
        if (folders.insert(draft.folder()).second)
            draft.make_name_durable();
}
namespace
{

std::string hex(XXH128_hash_t hash)
{
    XXH128_canonical_t bytes;
    XXH128_canonicalFromHash(&bytes, hash);
    return fmt::format("{:02x}", fmt::join(bytes.digest, ""));
}

}  // namespace

std::string content_hash(std::span<const std::byte> bytes)
{
    return hex(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string content_hash(std::string_view text)
{
    return content_hash(bytes_of(text));
}

std::string file_hash(const std::filesystem::path& file)
{
    // An input may be a link in a folder where links are forbidden; a FIFO must not be waited for.
    const FileDescriptor input =
        opened_file(file, FileDescriptor(uninterrupted([&] { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); })))
            .first;
    const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), &XXH3_freeState);
    XXH3_128bits_reset(state.get());
    std::vector<std::byte> buffer(std::size_t{1} << 20U);
    while (const std::size_t count = read_some(input, buffer, file))
        XXH3_128bits_update(state.get(), buffer.data(), count);
    return hex(XXH3_128bits_digest(state.get()));
}

}  // namespace fresco
