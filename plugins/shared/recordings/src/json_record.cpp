#include <fresco/recordings/json_record.h>

#include <fresco/error.h>

#include <cmath>
#include <vector>

namespace fresco::recordings
{

JsonRecord::JsonRecord(const Value& own, const Value& other, std::string place)
    : own_(own), other_(other), place_(std::move(place))
{
    if (!own.is_map())
        throw Error(place_ + ": expected a map, got a " + std::string(own.kind_name()));
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
        fail(key, value == nullptr ? "is missing" : "must be a text that is not empty");
    return value->as_string();
}

RigidTransform JsonRecord::transform(std::string_view key) const
{
    const Value* value = find(key);
    if (value == nullptr || !value->is_list())
        fail(key, value == nullptr ? "is missing" : "must be a list of rows");
    std::vector<double> matrix;
    for (const Value& row : value->as_list())
    {
        if (!row.is_list() || row.as_list().size() != 4)
            fail(key, "must have rows of 4 numbers");
        for (const Value& entry : row.as_list())
        {
            if (!entry.is_number())
                fail(key, "must have rows of 4 numbers");
            matrix.push_back(entry.as_double());
        }
    }
    if (matrix.size() == 12)
        matrix.insert(matrix.end(), {0, 0, 0, 1});
    return rigid_transform(matrix, place_ + ": \"" + std::string(key) + "\"");
}

void JsonRecord::fail(std::string_view key, const std::string& what) const
{
    throw Error(place_ + ": \"" + std::string(key) + "\" " + what);
}

}  // namespace fresco::recordings
