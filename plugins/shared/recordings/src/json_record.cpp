#include <fresco/recordings/json_record.h>

#include <fresco/error.h>

#include <cmath>

namespace fresco::recordings
{

JsonRecord::JsonRecord(const Value& own, const Value& other, std::string place)
    : own_(own), other_(other), place_(std::move(place))
{
    if (!own.is_map())
        throw Error(place_ + ": expected a map, got " + std::string(own.kind_name()));
}

const Value* JsonRecord::find(std::string_view key) const
{
    const Value* found = own_.find(key);
    return found != nullptr ? found : other_.find(key);
}

double JsonRecord::number(std::string_view key) const
{
    const Value* value = find(key);
    if (value == nullptr)
        fail(key, "is missing");
    if (!value->is_number() || !std::isfinite(value->as_double()))
        fail(key, "must be a number");
    return value->as_double();
}

double JsonRecord::number(std::string_view key, double fallback) const
{
    return find(key) == nullptr ? fallback : number(key);
}

int JsonRecord::pixels(std::string_view key) const
{
    const double count = number(key);
    if (!(count >= 1 && count <= 65536) || count != std::floor(count))
        fail(key, "must be a whole number of pixels from 1 to 65536");
    return static_cast<int>(count);
}

std::string JsonRecord::text(std::string_view key) const
{
    const Value* value = find(key);
    if (value == nullptr || !value->is_string() || value->as_string().empty())
        fail(key, value == nullptr ? "is missing" : "must be a non-empty text");
    return value->as_string();
}

std::vector<double> JsonRecord::matrix(std::string_view key) const
{
    const Value* value = find(key);
    if (value == nullptr || !value->is_list())
        fail(key, value == nullptr ? "is missing" : "must be a list of rows");
    std::vector<double> entries;
    for (const Value& row : value->as_list())
    {
        if (!row.is_list() || row.as_list().size() != 4)
            fail(key, "must have rows of 4 numbers");
        for (const Value& entry : row.as_list())
        {
            if (!entry.is_number())
                fail(key, "must have rows of 4 numbers");
            entries.push_back(entry.as_double());
        }
    }
    if (entries.size() == 12)
        entries.insert(entries.end(), {0, 0, 0, 1});
    return entries;
}

std::string JsonRecord::place_of(std::string_view key) const
{
    return place_ + ": \"" + std::string(key) + "\"";
}

void JsonRecord::fail(std::string_view key, const std::string& what) const
{
    throw Error(place_of(key) + " " + what);
}

}  // namespace fresco::recordings
