#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/option_declaration.h>

#include <algorithm>
#include <fmt/format.h>
#include <string_view>

namespace fresco
{
namespace
{

/// JSON is text, bytes are not.
std::string hex_of(std::string_view bytes)
{
    std::string hex;
    for (const char c : bytes)
        hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
    return hex;
}

std::string from_hex(const std::string& hex)
{
    std::string bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    return bytes;
}

Value described(const std::vector<std::string>& all)
{
    Value::List list;
    for (const std::string& bytes : all)
        list.push_back(hex_of(bytes));
    return list;
}

std::vector<std::string> read(const Value& list)
{
    std::vector<std::string> all;
    for (const Value& hex : list.as_list())
        all.push_back(from_hex(hex.as_string()));
    return all;
}

std::size_t size_at(const Value& description, std::string_view key)
{
    return static_cast<std::size_t>(description.at(key).as_int());
}

}  // namespace

Value FileFormat::describe() const
{
    return Value::Map{{"name", name},
                      {"extensions", Value::List(extensions.begin(), extensions.end())},
                      {"is_text", is_text},
                      {"begins", described(begins)},
                      {"begins_at", begins_at},
                      {"holds", described(holds)},
                      {"ends", described(ends)},
                      {"length_at", length_at},
                      {"length_bytes", length_bytes},
                      {"length_from", length_from}};
}

FileFormat FileFormat::from(const Value& description)
{
    FileFormat format;
    format.name = description.at("name").as_string();
    for (const Value& extension : description.at("extensions").as_list())
        format.extensions.push_back(extension.as_string());
    format.is_text = description.at("is_text").as_bool();
    format.begins = read(description.at("begins"));
    format.begins_at = size_at(description, "begins_at");
    format.holds = read(description.at("holds"));
    format.ends = read(description.at("ends"));
    format.length_at = size_at(description, "length_at");
    format.length_bytes = size_at(description, "length_bytes");
    format.length_from = size_at(description, "length_from");
    return format;
}

std::vector<std::string> all_extensions(const std::vector<FileFormat>& formats)
{
    std::vector<std::string> all;
    for (const FileFormat& format : formats)
        for (const std::string& extension : format.extensions)
            if (std::ranges::find(all, extension) == all.end())
                all.push_back(extension);
    return all;
}

FileFormat json_format()
{
    return {.name = "a JSON file", .extensions = {".json"}, .is_text = true, .begins = {"{", "["}, .ends = {"}", "]"}};
}

FileFormat npy_format()
{
    return {.name = "an NPY file", .extensions = {".npy"}, .begins = {"\x93NUMPY"}};
}

FileFormat ply_format()
{
    return {.name = "a PLY mesh", .extensions = {".ply"}, .begins = {"ply\n", "ply\r\n"}, .holds = {"\nend_header"}};
}

FileFormat obj_format()
{
    return {.name = "an OBJ mesh", .extensions = {".obj"}, .is_text = true, .holds = {"\nv ", "\nv\t"}, .ends = {"\n"}};
}

std::vector<FileFormat> picture_formats()
{
    // Programs save pictures of one kind by names of the other.
    const std::vector<std::string> extensions{".png", ".jpg", ".jpeg", ".webp", ".heic", ".heif", ".avif"};
    return {{.name = "a PNG picture", .extensions = extensions, .begins = {"\x89PNG\r\n\x1a\n"}, .ends = {"IEND"}},
            {.name = "a JPEG picture", .extensions = extensions, .begins = {"\xff\xd8\xff"}, .ends = {"\xff\xd9"}},
            {.name = "a WebP picture",
             .extensions = extensions,
             .begins = {"WEBP"},
             .begins_at = 8,
             .length_at = 4,
             .length_bytes = 4,
             .length_from = 8},
            {.name = "a HEIC or AVIF picture", .extensions = extensions, .begins = {"ftyp"}, .begins_at = 4}};
}

}  // namespace fresco
