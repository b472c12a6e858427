#include "base/journal.h"
#include "base/durable_file.h"
#include "base/file_lock.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/retry.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace fresco::host
{
namespace
{

/// Whether the next line would go on with one that was cut.
bool ends_within_line(int fd)
{
    struct stat status
    {
    };
    char last = '\n';
    return fstat(fd, &status) == 0 && status.st_size > 0 &&
           uninterrupted([&] { return pread(fd, &last, 1, status.st_size - 1); }) == 1 && last != '\n';
}

}  // namespace

std::vector<Value> Journal::read() const
{
    std::vector<Value> maps;
    std::string text;
    try
    {
        text = read_text_file(file_, std::size_t{1} << 30U);
    }
    catch (const Error&)
    {
        return maps;
    }
    for (std::size_t begin = 0; begin < text.size();)
    {
        const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
        if (auto map = map_of(std::string_view(text).substr(begin, end - begin)))
            maps.push_back(std::move(*map));
        begin = end;
    }
    return maps;
}

void Journal::add(const Value& map) const
{
    constexpr int patience = 100;  // times 20 ms
    FileLock lock(file_);
    for (int tries = 0; !lock.try_exclusive(); ++tries)
    {
        if (tries == patience)
            throw Error(file_.string() + ": others have held its lock for two seconds");
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    // Opened once it is locked: only then does a network file system know where it ends.
    const FileDescriptor fd(uninterrupted([&] { return open(file_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC); }));
    std::string text = checked_line(map);
    if (fd.valid() && ends_within_line(fd.get()))
        text.insert(0, 1, '\n');
    for (std::string_view rest = text; !rest.empty();)
    {
        const ssize_t count = fd.valid() ? uninterrupted([&] { return write(fd.get(), rest.data(), rest.size()); }) : -1;
        if (count < 0)
            throw Error(file_.string() + ": cannot be written: " + std::strerror(errno));
        rest.remove_prefix(static_cast<std::size_t>(count));
    }
}

void Journal::replace(const std::vector<Value>& maps) const
{
    std::string text;
    for (const Value& map : maps)
        text += checked_line(map);
    FileLock lock(file_);
    if (!lock.try_exclusive())
        throw Error(file_.string() + ": another process is writing it");
    write_durable_file(file_, text);
}

}  // namespace fresco::host
