#include "folder.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <fstream>
#include <set>

namespace fresco::studio
{
namespace
{
namespace fs = std::filesystem;

constexpr int deepest = 3;
constexpr std::size_t most_entries = 20'000;
constexpr std::size_t most_entries_of_a_mark = 2000;
const std::set<std::string> picture_extensions{".jpg", ".jpeg", ".png", ".webp", ".avif", ".heic", ".bmp"};
const std::set<std::string> weights_extensions{".safetensors", ".pth", ".pt"};
const std::set<std::string> model_extensions{".glb", ".gltf", ".obj", ".ply", ".splat", ".spz", ".sog"};

/// Names in a folder, without hidden ones, sorted; `budget` falls by their number.
std::vector<fs::path> entries_of(const fs::path& folder, std::size_t& budget)
{
    std::vector<fs::path> found;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error); !error && budget > 0 && entry != fs::directory_iterator();
         entry.increment(error))
    {
        --budget;
        if (!entry->path().filename().string().starts_with('.'))
            found.push_back(entry->path());
    }
    std::ranges::sort(found);
    return found;
}

/// Whether the folder has what `pattern` names: steps with '*' and '?'.
bool has(const fs::path& folder, const std::string& pattern, std::size_t& budget)
{
    const std::size_t end = pattern.find('/');
    const std::string step = pattern.substr(0, end);
    std::error_code error;
    const auto leads_on = [&](const fs::path& entry)
    { return end == std::string::npos || has(entry, pattern.substr(end + 1), budget); };
    if (step.find_first_of("*?") == std::string::npos)
        return fs::exists(folder / step, error) && leads_on(folder / step);
    for (fs::directory_iterator entry(folder, error); !error && budget > 0 && entry != fs::directory_iterator();
         entry.increment(error))
    {
        --budget;
        const std::string name = entry->path().filename();
        if (!name.starts_with('.') && fnmatch(step.c_str(), name.c_str(), 0) == 0 && leads_on(entry->path()))
            return true;
    }
    return false;
}

bool fits(const fs::path& folder, const Layout& layout)
{
    return !layout.contains.empty() &&
           std::ranges::all_of(layout.contains,
                               [&](std::string alternatives)
                               {
                                   for (std::size_t end = 0; end != std::string::npos;)
                                   {
                                       end = alternatives.find('|');
                                       std::size_t budget = most_entries_of_a_mark;
                                       if (has(folder, alternatives.substr(0, end), budget))
                                           return true;
                                       alternatives.erase(0, end == std::string::npos ? end : end + 1);
                                   }
                                   return false;
                               });
}

/// A color picture of a recording that browsers show.
std::string thumbnail_of(const fs::path& recording, const fs::path& folder, int depth)
{
    std::size_t budget = 2000;
    std::vector<fs::path> folders;
    for (const fs::path& entry : entries_of(recording, budget))
    {
        const std::string name = lower_case(entry.filename().string());
        const std::string extension = lower_extension(entry);
        std::error_code error;
        if (fs::is_symlink(entry, error) && !below(folder, entry.lexically_relative(folder).string()))
            continue;
        if (fs::is_directory(entry, error))
            folders.push_back(entry);
        else if ((extension == ".jpg" || extension == ".jpeg" || extension == ".png") &&
                 name.find("depth") == std::string::npos && name.find("mask") == std::string::npos &&
                 name.find("conf") == std::string::npos)
            return entry.lexically_relative(folder).string();
    }
    std::ranges::stable_sort(folders, {},
                             [](const fs::path& entry)
                             {
                                 const std::string name = lower_case(entry.filename().string());
                                 return name.find("depth") != std::string::npos || name.find("conf") != std::string::npos ? 1 : 0;
                             });
    for (const fs::path& inner : folders)
        if (depth > 0)
            if (std::string found = thumbnail_of(inner, folder, depth - 1); !found.empty())
                return found;
    return {};
}

class Search
{
  public:
    Search(const fs::path& folder, const std::vector<Layout>& layouts) : folder_(folder), layouts_(layouts) {}

    Contents found()
    {
        look_at(folder_, 0);
        contents.is_cut = budget_ == 0;
        return std::move(contents);
    }

  private:
    std::string name_of(const fs::path& path) const { return path.lexically_relative(folder_).string(); }

    void look_at(const fs::path& folder, int depth)
    {
        std::error_code error;
        if (fs::exists(folder / "progress.jsonl", error) || fs::exists(folder / "run.json", error))
        {
            if (fs::exists(folder / "progress.jsonl", error))
                contents.runs.push_back(name_of(folder));
            if (depth > 0)
                return;  // Results are not scans.
        }
        const auto layout = std::ranges::find_if(layouts_, [&](const Layout& each) { return fits(folder, each); });
        if (layout != layouts_.end())
        {
            contents.scans.push_back(
                {name_of(folder), paint::ScanKind::recording, layout->type, thumbnail_of(folder, folder_, 3)});
            if (depth > 0)
                return;
        }
        std::vector<fs::path> folders;
        for (const fs::path& entry : entries_of(folder, budget_))
        {
            if (fs::is_symlink(entry, error) && !below(folder_, name_of(entry)))
                continue;  // Links that lead out are not opened either.
            if (fs::is_directory(entry, error))
                folders.push_back(entry);
            else if (is_picture(entry) && layout == layouts_.end())
                contents.pictures.push_back(name_of(entry));
            else if (weights_extensions.contains(lower_extension(entry)))
                contents.weights.push_back(name_of(entry));
            else if (const std::string extension = lower_extension(entry); is_model(entry) && layout == layouts_.end())
                contents.scans.push_back({name_of(entry), paint::kind_of(entry), {}, {}});
            else
                for (const Layout& each : layouts_)
                    if (extension != ".json" && std::ranges::find(each.extensions, extension) != each.extensions.end())
                        contents.scans.push_back({name_of(entry), paint::ScanKind::recording, each.type, {}});
        }
        if (depth < deepest && layout == layouts_.end())
            for (const fs::path& inner : folders)
                look_at(inner, depth + 1);
    }

    const fs::path& folder_;
    const std::vector<Layout>& layouts_;
    std::size_t budget_ = most_entries;
    Contents contents;
};
}  // namespace

std::optional<fs::path> below(const fs::path& base, std::string_view name)
{
    if (name == ".")
        return base;
    const fs::path relative(name);
    if (name.empty() || name.find('\0') != std::string_view::npos || relative.is_absolute())
        return std::nullopt;
    for (const fs::path& step : relative)
        if (step.empty() || step.string().starts_with('.'))
            return std::nullopt;
    std::error_code error;
    const fs::path found = fs::canonical(base / relative, error);
    if (error)
        return std::nullopt;
    const auto [base_end, unused] = std::ranges::mismatch(base, found);
    return base_end == base.end() ? std::optional(found) : std::nullopt;
}

bool is_picture(const fs::path& file)
{
    return picture_extensions.contains(lower_extension(file));
}

bool is_model(const fs::path& file)
{
    return model_extensions.contains(lower_extension(file));
}

Contents contents_of(const fs::path& folder, const std::vector<Layout>& layouts)
{
    return Search(folder, layouts).found();
}

namespace
{

/// Whether a file begins as its name says; a picture may be of another kind, and .splat has no mark.
bool looks_as_named(const fs::path& file, const fs::path& wanted)
{
    std::string begin(12, '\0');
    std::ifstream(file, std::ios::binary).read(begin.data(), 12);
    const auto is = [&](std::string_view mark, std::size_t at = 0) { return begin.compare(at, mark.size(), mark) == 0; };
    if (is_picture(wanted))
        return is("\xff\xd8\xff") || is("\x89PNG") || is("RIFF") || is("BM") || is("ftyp", 4);
    const std::string extension = lower_extension(wanted);
    return extension == ".splat" || (extension == ".glb" && is("glTF")) || (extension == ".ply" && is("ply")) ||
           (extension == ".sog" && is("PK")) || (extension == ".spz" && (is("\x1f\x8b") || is("NGSP")));
}
}  // namespace

std::string take_in(const fs::path& upload, const fs::path& folder, const std::string& wanted)
{
    const std::string extension = lower_extension(wanted);
    if (!is_picture(wanted) && !is_model(wanted))
        throw Error(wanted + ": expected a model (" + join({model_extensions.begin(), model_extensions.end()}) +
                    ") or a picture (" + join({picture_extensions.begin(), picture_extensions.end()}) +
                    "); recordings are folders below this one");
    if (extension == ".gltf" || extension == ".obj")
        throw Error(wanted + ": its pictures are files of their own: put all of them into " + folder.string() +
                    ", or save it as GLB");
    if (!looks_as_named(upload, wanted))
        throw Error(wanted + ": its contents are not what its name says; export it again as " + extension.substr(1));
    std::string stem;
    for (const char c : fs::path(wanted).stem().string())
        stem += static_cast<unsigned char>(c) < 0x20 || c == '/' || c == 0x7F ? '_' : c;
    while (stem.starts_with('.'))
        stem.erase(0, 1);
    stem.resize(std::min<std::size_t>(stem.size(), 100));
    if (stem.empty())
        stem = "added";
    for (int count = 1; count < 10'000; ++count)
    {
        const std::string name = stem + (count > 1 ? fmt::format("_{}", count) : "") + extension;
        const fs::path file = folder / name;
        if (renameat2(AT_FDCWD, upload.c_str(), AT_FDCWD, file.c_str(), RENAME_NOREPLACE) == 0)
            return name;
        // Some file systems cannot do that: an empty file of one's own first, so that the rename replaces nobody's.
        if (errno == EINVAL && FileDescriptor(open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)).valid())
        {
            std::error_code error;
            fs::rename(upload, file, error);
            if (!error)
                return name;
            fs::remove(file);
            throw Error(name + ": cannot be written: " + error.message());
        }
        if (errno != EEXIST)
            throw Error(name + ": cannot be written: " + std::strerror(errno));
    }
    throw Error(wanted + ": too many files of this name");
}

Value as_value(const Contents& contents)
{
    Value::List scans;
    for (const Scan& scan : contents.scans)
        scans.push_back(Value::Map{{"name", scan.name},
                                   {"kind", scan.kind == paint::ScanKind::model    ? "model"
                                            : scan.kind == paint::ScanKind::splats ? "splat"
                                                                                   : "recording"},
                                   {"layout", scan.layout},
                                   {"thumbnail", scan.thumbnail}});
    return Value::Map{{"scans", std::move(scans)},
                      {"pictures", Value::List(contents.pictures.begin(), contents.pictures.end())},
                      {"runs", Value::List(contents.runs.begin(), contents.runs.end())},
                      {"is_cut", contents.is_cut}};
}

}  // namespace fresco::studio
