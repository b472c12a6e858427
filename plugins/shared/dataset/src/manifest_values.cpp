#include "manifest_values.h"

#include <fresco/dataset/manifest.h>
#include <fresco/error.h>
#include <fresco/frames.h>
#include <fresco/strict_map.h>

#include <algorithm>
#include <limits>

namespace fresco::dataset::detail
{
namespace
{

constexpr int rows = 3;
constexpr int columns = 4;

double pose_entry(const RigidTransform& transform, int row, int column)
{
    const double translation[] = {transform.translation.x, transform.translation.y, transform.translation.z};
    return column < rows ? transform.rotation(row, column) : translation[row];
}

RigidTransform pose_from(const Value& value)
{
    const auto fail = [] { throw Error("world_from_camera: expected three rows of four numbers"); };
    if (value.as_list().size() != rows)
        fail();
    RigidTransform pose;
    double* translation[] = {&pose.translation.x, &pose.translation.y, &pose.translation.z};
    for (int row = 0; row < rows; ++row)
    {
        const auto& numbers = value.as_list()[static_cast<std::size_t>(row)].as_list();
        if (numbers.size() != columns)
            fail();
        for (int column = 0; column < rows; ++column)
            pose.rotation(row, column) = numbers[static_cast<std::size_t>(column)].as_double();
        *translation[row] = numbers.back().as_double();
    }
    return pose;
}

int size_from(const Value& value)
{
    const std::int64_t size = value.as_int();
    // check_camera decides what is accepted; beyond an int it would see another number.
    return size > std::numeric_limits<int>::max() ? std::numeric_limits<int>::max()
                                                  : static_cast<int>(std::max<std::int64_t>(size, 0));
}

bool is_part(std::string_view part)
{
    const auto bad = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127 || c == '/' || c == '\\'; };
    return !part.empty() && part != "." && part != ".." && std::ranges::none_of(part, bad);
}

}  // namespace

Value camera_value(const Camera& camera)
{
    const Intrinsics& k = camera.intrinsics;
    Value::List pose;
    for (int row = 0; row < rows; ++row)
    {
        Value::List numbers;
        for (int column = 0; column < columns; ++column)
            numbers.emplace_back(pose_entry(camera.world_from_camera, row, column));
        pose.emplace_back(std::move(numbers));
    }
    return Value::Map{{"width", k.width},
                      {"height", k.height},
                      {"fx", k.fx},
                      {"fy", k.fy},
                      {"cx", k.cx},
                      {"cy", k.cy},
                      {"world_from_camera", std::move(pose)}};
}

Camera camera_from(const Value& value, const std::string& name)
{
    StrictMap entries(value);
    Camera camera;
    Intrinsics& k = camera.intrinsics;
    k.width = size_from(entries.take("width"));
    k.height = size_from(entries.take("height"));
    k.fx = entries.take("fx").as_double();
    k.fy = entries.take("fy").as_double();
    k.cx = entries.take("cx").as_double();
    k.cy = entries.take("cy").as_double();
    camera.world_from_camera = pose_from(entries.take("world_from_camera"));
    entries.refuse_others();
    check_camera(camera, name);
    return camera;
}

std::string checked_part(const std::string& text, const std::string& entry)
{
    if (!is_part(text))
        throw Error(entry + ": " + to_json(text) + " cannot be part of a file's name");
    return text;
}

std::string checked_name(const std::string& name)
{
    bool good = name != manifest_name;
    for (std::size_t start = 0; good && start <= name.size();)
    {
        const std::size_t end = std::min(name.find('/', start), name.size());
        good = is_part(std::string_view(name).substr(start, end - start));
        start = end + 1;
    }
    if (!good)
        throw Error("name: " + to_json(name) + " is not a file inside the dataset's folder");
    return name;
}

}  // namespace fresco::dataset::detail
