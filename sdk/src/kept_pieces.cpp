#include <fresco/kept_pieces.h>

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <fmt/format.h>
#include <system_error>
#include <utility>

namespace fresco
{
namespace fs = std::filesystem;

KeptPieces::KeptPieces(fs::path checkpoint) : checkpoint_(std::move(checkpoint))
{
    fs::create_directories(folder());
}

fs::path KeptPieces::note_of(std::size_t piece) const
{
    return checkpoint_ / fmt::format("piece_{}.json", piece);
}

std::optional<Value> KeptPieces::find(std::size_t piece) const
{
    if (!fs::exists(note_of(piece)))
        return std::nullopt;
    const Value note = parse_json(read_text_file(note_of(piece)), note_of(piece).string());
    for (const Value& file : note.at("files").as_list())
    {
        std::error_code gone;
        const auto bytes = fs::file_size(folder() / file.at("name").as_string(), gone);
        if (gone || bytes != static_cast<std::uintmax_t>(file.at("bytes").as_int()))
            return std::nullopt;
    }
    return note.at("about");
}

void KeptPieces::note(std::size_t piece, const std::vector<std::string>& files, Value about) const
{
    Value::List list;
    for (const std::string& name : files)
        list.emplace_back(Value::Map{{"name", name}, {"bytes", static_cast<std::size_t>(fs::file_size(folder() / name))}});
    write_file(note_of(piece), to_json(Value::Map{{"files", std::move(list)}, {"about", std::move(about)}}));
}

void KeptPieces::link(const std::vector<std::string>& files, const fs::path& to) const
{
    for (const std::string& name : files)
    {
        fs::create_directories((to / name).parent_path());
        std::error_code error;
        fs::remove(to / name, error);
        fs::create_hard_link(folder() / name, to / name, error);
        if (error && error != std::errc::no_such_file_or_directory && error != std::errc::no_space_on_device)
            fs::copy_file(folder() / name, to / name, error);
        if (error)
            throw Error((to / name).string() + ": cannot be written: " + error.message());
    }
}

}  // namespace fresco
