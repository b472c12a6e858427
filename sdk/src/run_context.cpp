#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/parallel.h>
#include <fresco/run_context.h>

#include <array>
#include <fmt/format.h>
#include <system_error>
#include <utility>

namespace fresco
{

Progress::~Progress() = default;
void Progress::progress(double, double, std::string_view) {}
void Progress::check_canceled() const {}
int Progress::threads() const
{
    return 1;
}

RunContext::~RunContext() = default;
namespace fs = std::filesystem;

KeptPieces::KeptPieces(RunContext& run) : run_(run), checkpoint_(run.checkpoint_folder())
{
    make_folder(folder());
}

fs::path KeptPieces::note_of(std::size_t piece) const
{
    return checkpoint_ / fmt::format("piece_{}.json", piece);
}

std::optional<Value> KeptPieces::find(std::size_t piece) const
{
    const fs::path file = note_of(piece);
    if (!path_status(file))
        return std::nullopt;
    try
    {
        const Value note = parse_json(read_checked_text(file), file.string());
        if (note.at("piece").as_int() != static_cast<std::int64_t>(piece))
            throw Error(file.string() + ": is the note of another piece");
        for (const auto& [name, hash] : note.at("files").as_map())
            if (file_hash(folder() / name) != hash.as_string())
                throw Error((folder() / name).string() + ": is damaged: its bytes do not fit its checksum");
        return note.at("about");
    }
    catch (const Error& error)
    {
        run_.warning(std::string("a finished piece is made again: ") + error.what());
        return std::nullopt;
    }
}

void KeptPieces::note(std::size_t piece, const std::vector<std::string>& files, Value about) const
{
    Value::Map hashes;
    for (const std::string& name : files)
        hashes.emplace_back(name, file_hash(folder() / name));
    write_checked(note_of(piece),
                  to_json(Value::Map{{"piece", piece}, {"files", std::move(hashes)}, {"about", std::move(about)}}));
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
            copy_files(std::array{FileCopy{folder() / name, to / name}});
        else if (error)
            throw Error((to / name).string() + ": cannot be written: " + error.message());
    }
}

}  // namespace fresco
