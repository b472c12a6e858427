#include <fresco/gltf/model_folder.h>

#include <fresco/error.h>

#include <algorithm>
#include <string>

namespace fresco::gltf
{

namespace fs = std::filesystem;

namespace
{

/// "C:\pictures", "https://…", "file:…": letters before a colon.
bool has_scheme(std::string_view name)
{
    const auto colon = name.find(':');
    return colon != std::string_view::npos && colon > 0 && name.substr(0, colon).find_first_of("/\\ .") == std::string_view::npos;
}

bool is_inside(const fs::path& file, const fs::path& folder)
{
    const auto [in_folder, in_file] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    return in_folder == folder.end() && in_file != file.end();
}

}  // namespace

ModelFolder::ModelFolder(const fs::path& model) : folder_(model.parent_path().empty() ? fs::path(".") : model.parent_path()) {}

fs::path ModelFolder::find(std::string_view name, std::string_view place, std::string_view way_out) const
{
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
    std::string shown(name.substr(0, 200));
    std::ranges::replace_if(shown, is_control, '?');
    const std::string begin = std::string(place) + ": \"" + shown + "\" ";
    if (name.empty() || std::ranges::any_of(name, is_control))
        throw Error(begin + "is not a file name");
    std::string text(name);
    std::ranges::replace(text, '\\', '/');
    const fs::path relative(text);
    const bool leaves = std::ranges::find(relative, fs::path("..")) != relative.end();
    if (relative.is_absolute() || leaves || has_scheme(name))
        throw Error(begin + "is outside the model's folder; put the file beside the model and use only its name");
    fs::path file = folder_ / relative;
    std::error_code error;
    if (!fs::is_regular_file(file, error))
        throw MissingInput(begin + "is not in " + folder_.string() + "; put it there" + std::string(way_out));
    if (!is_inside(fs::canonical(file), fs::canonical(folder_)))
        throw Error(begin + "is a link to a file outside the model's folder; put the file itself there");
    return file;
}

bool ModelFolder::has(std::string_view name) const
{
    try
    {
        return !find(name, "").empty();
    }
    catch (const Error&)
    {
        return false;
    }
}

std::string_view suffix_of(std::span<const std::byte> picture)
{
    const std::string_view text(reinterpret_cast<const char*>(picture.data()), picture.size());
    const auto has = [&](std::size_t at, std::string_view mark) { return text.size() > at && text.substr(at).starts_with(mark); };
    if (has(0, "\x89PNG"))
        return ".png";
    if (has(0, "\xFF\xD8\xFF"))
        return ".jpg";
    if (has(0, "RIFF") && has(8, "WEBP"))
        return ".webp";
    return has(4, "ftyp") ? ".heic" : "";
}

}  // namespace fresco::gltf
