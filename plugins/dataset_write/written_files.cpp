#include "written_files.h"

using namespace fresco;

std::vector<std::string> WrittenFiles::names() const
{
    std::vector<std::string> result;
    for (const auto& [name, stamp] : files)
        result.push_back(name);
    return result;
}

Value to_value(const WrittenFiles& written)
{
    return Value::Map{{"sharpness", written.sharpness}, {"files", dataset::stamps_value(written.files)}};
}

WrittenFiles written_files_from(const Value& value)
{
    WrittenFiles written;
    written.sharpness = value.at("sharpness").as_double();
    for (const Value& file : value.at("files").as_list())
        written.files[file.at("name").as_string()] = {static_cast<std::uint64_t>(file.at("bytes").as_int()),
                                                      file.at("hash").as_string()};
    return written;
}
