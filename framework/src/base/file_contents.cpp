#include "base/file_contents.h"
#include "base/common.h"
#include <fresco/text.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

namespace fresco::host
{
namespace
{
constexpr std::size_t beginning_bytes = 4096;
/// How far a text is searched for what it must hold.
constexpr std::size_t searched_bytes = std::size_t{1} << 20U;
constexpr std::string_view white_space = " \t\r\n";

/// A file that is read in pieces.
class OpenFile
{
  public:
    explicit OpenFile(const fs::path& file)
    {
        std::error_code failure;
        if (fs::is_regular_file(file, failure))
            stream_.open(file, std::ios::binary);
        size_ = stream_.is_open() ? fs::file_size(file, failure) : 0;
        beginning_ = part(0, beginning_bytes);
    }

    bool is_readable() const { return stream_.is_open() && beginning_.size() == std::min(size_, beginning_bytes); }
    std::size_t size() const { return size_; }
    std::string_view beginning() const { return beginning_; }
    /// Less than `count` bytes at the end of the file.
    std::string part(std::size_t offset, std::size_t count) const
    {
        std::string bytes(std::min(count, size_ - std::min(offset, size_)), '\0');
        stream_.clear();
        stream_.seekg(static_cast<std::streamoff>(offset));
        stream_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.resize(static_cast<std::size_t>(stream_.gcount()));
        return bytes;
    }
    std::string end(std::size_t count) const { return part(size_ - std::min(count, size_), count); }

  private:
    mutable std::ifstream stream_;
    std::string beginning_;
    std::size_t size_ = 0;
};

bool begins(const OpenFile& file, const FileFormat& format)
{
    std::string_view text = file.beginning();
    if (format.is_text)
    {
        if (text.find('\0') != std::string_view::npos)
            return false;
        if (text.starts_with("\xef\xbb\xbf"))
            text.remove_prefix(3);
        text.remove_prefix(std::min(text.find_first_not_of(white_space), text.size()));
    }
    text.remove_prefix(std::min(format.begins_at, text.size()));
    return format.begins.empty() ||
           std::ranges::any_of(format.begins, [&](const std::string& each) { return text.starts_with(each); });
}

/// The line's end before what is held stands for the beginning of the file, too.
bool holds(const OpenFile& file, const FileFormat& format)
{
    const auto in = [&](const std::string& text)
    { return std::ranges::any_of(format.holds, [&](const std::string& each) { return text.find(each) != std::string::npos; }); };
    return format.holds.empty() || in("\n" + std::string(file.beginning())) || in("\n" + file.part(0, searched_bytes));
}

/// A text ends with it; in another file it is searched from the end, behind which programs put data of their own.
bool has_end(const OpenFile& file, const FileFormat& format)
{
    if (format.ends.empty())
        return true;
    const auto in = [&](auto test) { return std::ranges::any_of(format.ends, test); };
    if (format.is_text)
    {
        const std::string text = file.end(beginning_bytes);
        return in([&](const std::string& end) { return text.ends_with(end) || trimmed(text).ends_with(end); });
    }
    constexpr std::size_t piece = std::size_t{1} << 16U;
    const std::size_t overlap = std::ranges::max(format.ends, {}, &std::string::size).size() - 1;
    for (std::size_t end = file.size(); end > 0;)
    {
        const std::size_t begin = end - std::min(end, piece);
        const std::string text = file.part(begin, end - begin + overlap);
        if (in([&](const std::string& each) { return text.find(each) != std::string::npos; }))
            return true;
        end = begin;
    }
    return false;
}

bool is_long_enough(const OpenFile& file, const FileFormat& format)
{
    if (format.length_bytes == 0 || file.size() < format.length_from)
        return format.length_bytes == 0;
    const std::string bytes = file.part(format.length_at, format.length_bytes);
    std::uint64_t length = 0;
    for (std::size_t i = bytes.size(); i-- > 0;)
        length = length << 8U | static_cast<unsigned char>(bytes[i]);
    return bytes.size() == format.length_bytes && length <= file.size() - format.length_from;
}

/// A format without a beginning of its own may be recognized late in the file.
bool is_of(const OpenFile& file, const FileFormat& format)
{
    return begins(file, format) && (!format.begins.empty() || holds(file, format) || file.size() > searched_bytes);
}

bool is_whole(const OpenFile& file, const FileFormat& format)
{
    return (format.begins.empty() || holds(file, format)) && has_end(file, format) && is_long_enough(file, format);
}

}  // namespace

std::string unreachable_text(int error)
{
    if (error == 0 || error == ENOENT || error == ENOTDIR)
        return "";
    return error == ENAMETOOLONG ? "the path is too long" : std::string("cannot be reached: ") + std::strerror(error);
}

std::string known_kind(const fs::path& path, const std::vector<FileFormat>& formats)
{
    const OpenFile file(path);
    const auto known = std::ranges::find_if(formats, [&](const FileFormat& format)
                                            { return format.extensions.empty() && file.size() > 0 && begins(file, format); });
    return known == formats.end() ? "" : known->name;
}

std::string file_problem(const fs::path& path, const std::vector<std::string>& extensions, const std::vector<FileFormat>& formats)
{
    const OpenFile file(path);
    if (!file.is_readable())
        return "";
    const std::string shown = "'" + path.string() + "'";
    if (const std::string kind = known_kind(path, formats); !kind.empty())
        return shown + " is " + kind;
    const std::string extension = lower_extension(path);
    if (std::ranges::find(extensions, extension) == extensions.end())
        return shown + (extension.empty() ? " has no extension" : " is a " + extension + " file") + "; expected " +
               join(extensions, " or ");
    if (file.size() == 0)
        return shown + " is empty";
    std::vector<FileFormat> fitting;
    std::ranges::copy_if(formats, std::back_inserter(fitting),
                         [&](const FileFormat& format)
                         { return std::ranges::find(format.extensions, extension) != format.extensions.end(); });
    if (fitting.empty())
        return "";
    const auto format = std::ranges::find_if(fitting, [&](const FileFormat& each) { return is_of(file, each); });
    if (format != fitting.end())
        return is_whole(file, *format) ? "" : shown + " is cut short: copy or export it again";
    std::vector<std::string> names;
    for (const FileFormat& each : fitting)
        if (std::ranges::find(names, each.name) == names.end())
            names.push_back(each.name);
    return shown + " is not " + join(names, " or ");
}

}  // namespace fresco::host
