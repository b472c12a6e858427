#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

void check_name(const std::string& name, const fs::path& folder)
{
    const fs::path path = name;
    if (name.empty() || path.is_absolute() || std::ranges::find(path, fs::path("..")) != path.end())
        throw Error(folder.string() + ": \"" + name + "\" is not a relative file name without \"..\"");
    if (!is_file(folder / path))
        throw Error((folder / path).string() + ": is listed but was not written");
}

}  // namespace

void Files::save(const ArtifactFolder& folder) const
{
    for (const std::string& name : names)
        check_name(name, folder.path);
    write_file(folder.path / "files.json", to_json(Value::Map{{"files", Value::List(names.begin(), names.end())}}, 1));
}

std::shared_ptr<Files> Files::load(const ArtifactFolder& folder)
{
    auto files = std::make_shared<Files>();
    files->loaded_from = folder.path;
    files->names = detail::JsonFile(folder.path / "files.json")["files"].texts();
    for (const std::string& name : files->names)
        check_name(name, folder.path);
    return files;
}

std::shared_ptr<Files> Files::from_exchange(const Exchange& from)
{
    const fs::path& folder = from.folder.path;
    auto files = std::make_shared<Files>();
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (!entry.is_directory())
            files->names.push_back(entry.path().lexically_relative(folder).generic_string());
    std::ranges::sort(files->names);
    if (files->names.empty())
        throw Error(folder.string() + ": no file was written into it");
    if (std::ranges::find(files->names, "files.json") != files->names.end())
        throw Error((folder / "files.json").string() + ": this name is taken for the list of files; write another");
    return files;
}

std::vector<ExchangeForm> Table::exchange_forms()
{
    return {{.files = {"table.json"}, .is_folder = false, .taken_in_place = false, .made_in_place = false}};
}

void Table::save(const ArtifactFolder& folder) const
{
    Value::List list;
    for (const auto& row : rows)
    {
        if (row.size() != columns.size())
            throw Error(fmt::format("a table of {} columns has a row of {}", columns.size(), row.size()));
        list.emplace_back(Value::List(row.begin(), row.end()));
    }
    write_file(folder.path / "table.json",
               to_json(Value::Map{{"columns", Value::List(columns.begin(), columns.end())}, {"rows", std::move(list)}}, 1));
}

std::shared_ptr<Table> Table::load(const ArtifactFolder& folder)
{
    const detail::JsonFile file(folder.path / "table.json");
    auto table = std::make_shared<Table>();
    table->columns = file["columns"].texts();
    for (const JsonPlace& row : file["rows"].list())
    {
        (void)row.list(table->columns.size());
        table->rows.push_back(row.value().as_list());
    }
    return table;
}

}  // namespace fresco
