#include "written_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <system_error>
#include <utility>

using namespace fresco;
namespace fs = std::filesystem;

KeptViews::KeptViews(fs::path checkpoint) : checkpoint_(std::move(checkpoint))
{
    fs::create_directories(folder());
}

fs::path KeptViews::note_of(std::size_t view) const
{
    return checkpoint_ / ("view_" + std::to_string(view) + ".json");
}

std::optional<WrittenFiles> KeptViews::find(std::size_t view) const
{
    if (!fs::exists(note_of(view)))
        return std::nullopt;
    const Value note = parse_json(read_text_file(note_of(view)), note_of(view).string());
    WrittenFiles written;
    written.sharpness = note.at("sharpness").as_double();
    for (const Value& file : note.at("files").as_list())
    {
        const std::string name = file.at("name").as_string();
        const auto bytes = static_cast<std::uint64_t>(file.at("bytes").as_int());
        std::error_code gone;
        if (fs::file_size(folder() / name, gone) != bytes || gone)
            return std::nullopt;
        written.files[name] = {bytes, file.at("hash").as_string()};
    }
    return written;
}

void KeptViews::note(std::size_t view, const WrittenFiles& written) const
{
    const Value value = Value::Map{{"sharpness", written.sharpness}, {"files", dataset::stamps_value(written.files)}};
    write_file(note_of(view), to_json(value));
}

void move_file(const fs::path& from_folder, const fs::path& to_folder, const std::string& name)
{
    const fs::path to = to_folder / name;
    fs::create_directories(to.parent_path());
    std::error_code error;
    fs::rename(from_folder / name, to, error);
    if (error == std::errc::cross_device_link)
    {
        error.clear();
        fs::copy_file(from_folder / name, to, fs::copy_options::overwrite_existing, error);
    }
    if (error)
        throw Error(to.string() + ": cannot be written: " + error.message());
}
