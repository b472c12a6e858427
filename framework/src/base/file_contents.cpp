#include "base/file_contents.h"
#include <fresco/file_access.h>
#include <fresco/process.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <fcntl.h>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{
namespace fs = std::filesystem;
using namespace std::literals;

constexpr std::size_t beginning_bytes = 4096;
/// How far a text is searched for what it must hold.
constexpr std::size_t searched_bytes = std::size_t{1} << 20U;
constexpr std::string_view white_space = " \t\r\n";

/// A file that is read in pieces.
class OpenFile
{
  public:
    explicit OpenFile(const fs::path& file)
        : fd_(uninterrupted([&] { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); }))
    {
        struct stat status
        {
        };
        readable_ = fd_.valid() && ::fstat(fd_.get(), &status) == 0 && S_ISREG(status.st_mode);
        size_ = readable_ ? static_cast<std::size_t>(status.st_size) : 0;
        beginning_ = part(0, beginning_bytes);
        readable_ = readable_ && beginning_.size() == std::min(size_, beginning_bytes);
    }

    bool is_readable() const { return readable_; }
    std::size_t size() const { return size_; }
    std::string_view beginning() const { return beginning_; }
    /// Less than `count` bytes at the end of the file.
    std::string part(std::size_t offset, std::size_t count) const
    {
        std::string bytes(std::min(count, size_ - std::min(offset, size_)), '\0');
        std::size_t done = 0;
        while (done < bytes.size())
        {
            const ssize_t got = uninterrupted(
                [&] { return ::pread(fd_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done)); });
            if (got <= 0)
                break;
            done += static_cast<std::size_t>(got);
        }
        bytes.resize(done);
        return bytes;
    }
    std::string end(std::size_t count) const { return part(size_ - std::min(count, size_), count); }

  private:
    FileDescriptor fd_;
    std::string beginning_;
    std::size_t size_ = 0;
    bool readable_ = false;
};

std::uint32_t big_endian(std::string_view bytes)
{
    std::uint32_t number = 0;
    for (const char c : bytes.substr(0, 4))
        number = number << 8U | static_cast<unsigned char>(c);
    return number;
}

std::uint64_t little_endian(std::string_view bytes)
{
    std::uint64_t number = 0;
    for (std::size_t i = bytes.size(); i-- > 0;)
        number = number << 8U | static_cast<unsigned char>(bytes[i]);
    return number;
}

constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";

bool begins_as_picture(const OpenFile& file)
{
    return file.beginning().starts_with(png_signature) || file.beginning().starts_with("\xff\xd8\xff");
}

/// Chunk after chunk to IEND.
bool is_whole_png(const OpenFile& file)
{
    for (std::size_t at = png_signature.size();;)
    {
        const std::string head = file.part(at, 8);
        if (head.size() < 8)
            return false;
        at += 12 + std::size_t{big_endian(head)};
        if (at > file.size())
            return false;
        if (head.ends_with("IEND"))
            return true;
    }
}

/// The picture's data begin behind the segments, of which one may hold a small picture of its own; the marker of the end is the
/// last of the file, unless a camera has put more behind it.
bool is_whole_jpeg(const OpenFile& file)
{
    std::size_t data = 2;
    for (std::string head = file.part(data, 4); !head.starts_with("\xff\xda"); head = file.part(data, 4))
    {
        if (head.size() < 4)
            return false;
        data += 2 + (big_endian(head) & 0xFFFFU);
    }
    constexpr std::size_t piece = std::size_t{1} << 16U;
    for (std::size_t end = file.size(); end > data;)
    {
        // One byte of the piece behind it, too: the marker may lie across.
        const std::size_t begin = end - std::min(end - data, piece);
        if (file.part(begin, end - begin + 1).find("\xff\xd9") != std::string::npos)
            return true;
        end = begin;
    }
    return false;
}

bool is_whole_picture(const OpenFile& file)
{
    return file.beginning().starts_with(png_signature) ? is_whole_png(file) : is_whole_jpeg(file);
}

bool begins_as_npy(const OpenFile& file)
{
    return file.beginning().starts_with("\x93NUMPY");
}

bool begins_as_ply(const OpenFile& file)
{
    return file.beginning().starts_with("ply\n") || file.beginning().starts_with("ply\r\n");
}

bool is_whole_ply(const OpenFile& file)
{
    return file.beginning().find("\nend_header") != std::string_view::npos ||
           file.part(0, searched_bytes).find("\nend_header") != std::string::npos;
}

bool has_vertex_line(std::string_view text)
{
    return text.starts_with("v ") || text.find("\nv ") != std::string_view::npos || text.find("\nv\t") != std::string_view::npos;
}

/// An OBJ has no signature: a text in which a line with a vertex comes soon.
bool begins_as_obj(const OpenFile& file)
{
    if (file.beginning().find('\0') != std::string_view::npos)
        return false;
    return has_vertex_line(file.beginning()) || file.size() > searched_bytes || has_vertex_line(file.part(0, searched_bytes));
}

bool ends_line(const OpenFile& file)
{
    return file.end(1) == "\n";
}

bool begins_as_glb(const OpenFile& file)
{
    return file.beginning().starts_with("glTF");
}

bool is_whole_glb(const OpenFile& file)
{
    return file.size() >= 12 && little_endian(file.beginning().substr(8, 4)) <= file.size();
}

bool begins_as_json(const OpenFile& file)
{
    std::string_view text = file.beginning();
    if (text.starts_with("\xef\xbb\xbf"))
        text.remove_prefix(3);
    const std::size_t first = text.find_first_not_of(white_space);
    return first != std::string_view::npos && (text[first] == '{' || text[first] == '[');
}

bool is_whole_json(const OpenFile& file)
{
    const std::string text = file.end(beginning_bytes);
    const std::size_t last = text.find_last_not_of(white_space);
    return last != std::string::npos && (text[last] == '}' || text[last] == ']');
}

bool begins_as_sens(const OpenFile& file)
{
    return file.beginning().starts_with("\x04\0\0\0"sv);
}

bool is_safetensors(const OpenFile& file)
{
    return file.size() > 8 && file.beginning()[8] == '{';
}

bool begins_as_weights(const OpenFile& file)
{
    return is_safetensors(file) || file.beginning().starts_with("PK\x03\x04") || file.beginning().starts_with("\x80");
}

bool is_whole_weights(const OpenFile& file)
{
    return !is_safetensors(file) || little_endian(file.beginning().substr(0, 8)) <= file.size() - 8;
}

bool always(const OpenFile&)
{
    return true;
}

struct Format
{
    std::string_view name;
    std::array<std::string_view, 3> extensions;  ///< Of each other's contents, where there are several.
    bool (*begins)(const OpenFile&);
    bool (*is_whole)(const OpenFile&);
    bool has_signature = true;  ///< No other format begins so.
};

constexpr std::array formats{Format{"a PNG or JPEG picture", {".png", ".jpg", ".jpeg"}, begins_as_picture, is_whole_picture},
                             Format{"an NPY file", {".npy"}, begins_as_npy, always},
                             Format{"a PLY mesh", {".ply"}, begins_as_ply, is_whole_ply},
                             Format{"an OBJ mesh", {".obj"}, begins_as_obj, ends_line, false},
                             Format{"a GLB model", {".glb"}, begins_as_glb, is_whole_glb},
                             Format{"a glTF model", {".gltf"}, begins_as_json, is_whole_json, false},
                             Format{"a JSON file", {".json"}, begins_as_json, is_whole_json, false},
                             Format{"a .sens recording of version 4", {".sens"}, begins_as_sens, always, false},
                             Format{"a safetensors file or a PyTorch state dict",
                                    {".safetensors", ".pth", ".pt"},
                                    begins_as_weights,
                                    is_whole_weights,
                                    false}};

const Format* format_of(std::string_view extension)
{
    for (const Format& format : formats)
        if (std::ranges::find(format.extensions, extension) != format.extensions.end())
            return &format;
    return nullptr;
}

/// ": it begins with …", or what it is instead; empty if that would not help.
std::string seen_in(const OpenFile& file)
{
    for (const Format& format : formats)
        if (format.has_signature && format.begins(file))
            return ": it is " + std::string(format.name);
    constexpr std::size_t shown = 32;
    const std::string_view text = file.beginning();
    const auto is_shown = [](char c) { return c >= ' ' && c <= '~'; };
    const std::string_view line(text.begin(), std::ranges::find_if_not(text, is_shown));
    return line.size() < 4 ? ""
                           : ": it begins with \"" + std::string(line.substr(0, shown)) + (line.size() > shown ? "…\"" : "\"");
}

std::string lower_extension(const fs::path& file)
{
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return extension;
}

}  // namespace

std::string file_problem(const fs::path& path, const std::vector<std::string>& extensions)
{
    const OpenFile file(path);
    if (!file.is_readable())
        return "";
    const std::string shown = "'" + path.string() + "'";
    const std::string extension = lower_extension(path);
    if (std::ranges::find(extensions, extension) == extensions.end())
        return shown + (extension.empty() ? " has no extension" : " is a " + extension + " file") + "; expected " +
               join(extensions, " or ");
    if (file.size() == 0)
        return shown + " is empty";
    const Format* format = format_of(extension);
    if (format == nullptr)
        return "";
    if (!format->begins(file))
        return shown + " is not " + std::string(format->name) + seen_in(file);
    return format->is_whole(file) ? "" : shown + " is cut short: copy or export it again";
}

}  // namespace fresco::host
