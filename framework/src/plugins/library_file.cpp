#include "base/process.h"
#include "plugins/plugin_library.h"
#include <fresco/file_access.h>

#include <cerrno>
#include <cstring>
#include <elf.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

const char* kind_of(mode_t mode)
{
    if (S_ISDIR(mode))
        return "a folder";
    if (S_ISFIFO(mode))
        return "a FIFO";
    if (S_ISSOCK(mode))
        return "a socket";
    if (S_ISCHR(mode) || S_ISBLK(mode))
        return "a device";
    return "no regular file";
}

template <class T>
bool read_at(int fd, std::uint64_t offset, T& into)
{
    return pread(fd, &into, sizeof into, static_cast<off_t>(offset)) == static_cast<ssize_t>(sizeof into);
}

std::string cut_short(std::uint64_t needed, std::uint64_t size)
{
    return "is cut short: its headers speak of " + std::to_string(needed) + " bytes, it has " + std::to_string(size);
}

}  // namespace

std::optional<std::string> library_file_problem(const std::filesystem::path& file)
{
    struct stat status
    {
    };
    if (stat(file.c_str(), &status) != 0)
        return std::string("cannot be looked at: ") + std::strerror(errno);
    if (!S_ISREG(status.st_mode))
        return std::string("is ") + kind_of(status.st_mode) + ", not a shared library";
    const FileDescriptor fd(uninterrupted([&] { return open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); }));
    if (!fd.valid())
        return std::string("cannot be opened: ") + std::strerror(errno);

    const auto size = static_cast<std::uint64_t>(status.st_size);
    Elf64_Ehdr header{};
    Elf64_Ehdr own{};
    if (size < SELFMAG)
        return "is not a shared library: it has " + std::to_string(size) + " bytes";
    if (!read_at(fd.get(), 0, header))
    {
        char magic[SELFMAG] = {};
        const bool elf = read_at(fd.get(), 0, magic) && std::memcmp(magic, ELFMAG, SELFMAG) == 0;
        return elf ? cut_short(sizeof header, size) : "is not a shared library: it does not begin as an ELF file";
    }
    if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
        return "is not a shared library: it does not begin as an ELF file";
    const FileDescriptor program(uninterrupted([&] { return open("/proc/self/exe", O_RDONLY | O_CLOEXEC); }));
    if (read_at(program.get(), 0, own) && (header.e_ident[EI_CLASS] != own.e_ident[EI_CLASS] ||
                                           header.e_ident[EI_DATA] != own.e_ident[EI_DATA] || header.e_machine != own.e_machine))
        return "is made for another kind of machine (ELF machine " + std::to_string(header.e_machine) + ", this one is " +
               std::to_string(own.e_machine) + ")";
    if (header.e_type != ET_DYN)
        return "is not a shared library (ELF type " + std::to_string(header.e_type) + ")";
    const std::uint64_t sections_end = header.e_shoff + std::uint64_t{header.e_shentsize} * header.e_shnum;
    if (header.e_shoff != 0 && (sections_end < header.e_shoff || sections_end > size))
        return cut_short(sections_end, size);
    for (std::uint64_t i = 0; i < header.e_phnum; ++i)
    {
        Elf64_Phdr segment{};
        const std::uint64_t offset = header.e_phoff + i * sizeof segment;
        if (!read_at(fd.get(), offset, segment))
            return cut_short(offset + sizeof segment, size);
        if (segment.p_type == PT_LOAD && (segment.p_offset > size || segment.p_filesz > size - segment.p_offset))
            return cut_short(segment.p_offset + segment.p_filesz, size);
    }
    return std::nullopt;
}

}  // namespace fresco::host
