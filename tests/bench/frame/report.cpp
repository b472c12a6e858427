#include "report.h"

#include <fresco/files_io.h>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <fstream>
#include <span>
#include <thread>

namespace bench
{
namespace
{

nlohmann::ordered_json json_of(const fresco::Value& value)
{
    if (value.is_bool())
        return value.as_bool();
    if (value.is_int())
        return value.as_int();
    if (value.is_number())
        return value.as_double();
    if (value.is_string())
        return value.as_string();
    auto result = value.is_map() ? nlohmann::ordered_json::object() : nlohmann::ordered_json::array();
    if (value.is_null())
        return nullptr;
    if (value.is_list())
        for (const auto& item : value.as_list())
            result.push_back(json_of(item));
    else
        for (const auto& [key, item] : value.as_map())
            result[key] = json_of(item);
    return result;
}

std::string processor()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

}  // namespace

Report::Report(std::string suite, fresco::Value settings)
{
    const auto machine =
        fresco::Value::Map{{"processor", processor()}, {"cores", static_cast<int>(std::thread::hardware_concurrency())}};
    all_ = fresco::Value::Map{
        {"suite", std::move(suite)}, {"machine", machine}, {"settings", std::move(settings)}, {"tables", fresco::Value::Map{}}};
    std::printf("%s\n%s\n", fresco::to_json(all_.at("machine")).c_str(), fresco::to_json(all_.at("settings")).c_str());
    std::fflush(stdout);
}

void Report::add(const Table& table)
{
    std::printf("%s", table.text().c_str());
    std::fflush(stdout);
    all_.find("tables")->set(table.name(), table.rows());
}

void Report::write(const std::filesystem::path& file) const
{
    const std::string text = json_of(all_).dump(2) + "\n";
    fresco::write_file(file, std::as_bytes(std::span(text)));
}

}  // namespace bench
