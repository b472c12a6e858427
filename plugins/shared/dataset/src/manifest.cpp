#include <fresco/camera.h>
#include <fresco/dataset/manifest.h>
#include <fresco/error.h>
#include <fresco/frames.h>
#include <fresco/strict_map.h>
#include <fresco/value.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <utility>

/// \file Pieces of the manifest, read strictly. What is not as expected is an Error that names the entry; the caller adds the
/// file.

namespace fresco::dataset
{

namespace
{

/// {width, height, fx, fy, cx, cy, world_from_camera: three rows of four}
Value camera_value(const Camera& camera);
Camera camera_from(const Value& value, const std::string& name);

/// The same text, checked to be usable as one part of a path.
std::string checked_part(const std::string& text, const std::string& entry);
/// The same name, checked to lead to a file below the folder it is relative to.
std::string checked_name(const std::string& name);

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

constexpr std::string_view format_name = "fresco.dataset";
constexpr int format_version = 1;
constexpr int largest_height = 65536;

Value conventions()
{
    return Value::Map{{"length_unit", "meter"},
                      {"camera_axes", "OpenCV: x right, y down, z forward"},
                      {"poses", "world_from_camera, 3 x 4, row by row"},
                      {"pixel_centers", 0.5},
                      {"uv_origin", "lower left"},
                      {"rows", "top first"},
                      {"depth", "along the optical axis"},
                      {"colors", "sRGB, RGB"},
                      {"hashes", "XXH3, 128 bits"}};
}

std::string view_folder(std::size_t view)
{
    char number[24];
    std::snprintf(number, sizeof number, "%06zu", view);
    return std::string("views/") + number + "/";
}

const char* word_of(UvType uv)
{
    return uv == UvType::float32 ? "float32" : "uint16";
}

Value to_value(const View& view)
{
    return Value::Map{{"sequence", view.sequence},
                      {"frame", view.frame},
                      {"number", view.number},
                      {"color_camera", camera_value(view.color)},
                      {"depth_camera", camera_value(view.depth)},
                      {"depth_unit_m", view.depth_unit_m ? Value(*view.depth_unit_m) : Value()},
                      {"sharpness", view.sharpness},
                      {"valid_pixels", Value::List(view.valid_pixels.begin(), view.valid_pixels.end())}};
}

View view_from(const Value& value, const std::vector<int>& heights_px)
{
    StrictMap entries(value);
    View view;
    view.sequence = checked_part(entries.take("sequence").as_string(), "sequence");
    view.frame = checked_part(entries.take("frame").as_string(), "frame");
    view.number = entries.take("number").as_int();
    view.color = camera_from(entries.take("color_camera"), "color_camera");
    view.depth = camera_from(entries.take("depth_camera"), "depth_camera");
    if (const Value& unit = entries.take("depth_unit_m"); !unit.is_null())
        view.depth_unit_m = unit.as_double();
    if (view.depth_unit_m && !(*view.depth_unit_m > 0))
        throw Error("depth_unit_m: expected a number above 0, or null");
    view.sharpness = entries.take("sharpness").as_double();
    if (!(view.sharpness >= 0))
        throw Error("sharpness: expected a number that is not negative");
    for (const Value& count : entries.take("valid_pixels").as_list())
        view.valid_pixels.push_back(count.as_int());
    entries.refuse_others();
    if (view.valid_pixels.size() != heights_px.size())
        throw Error(
            fmt::format("valid_pixels: {} numbers; expected one per height, {}", view.valid_pixels.size(), heights_px.size()));
    for (std::size_t i = 0; i < heights_px.size(); ++i)
    {
        const std::int64_t most = std::int64_t{heights_px[i]} * view.color.intrinsics.width_at(heights_px[i]);
        if (view.valid_pixels[i] < 0 || view.valid_pixels[i] > most)
            throw Error(fmt::format("valid_pixels: {} of the {} pixels at {} px", view.valid_pixels[i], most, heights_px[i]));
    }
    return view;
}

std::pair<std::string, FileStamp> file_from(const Value& value)
{
    StrictMap entries(value);
    const std::string name = checked_name(entries.take("name").as_string());
    const std::int64_t bytes = entries.take("bytes").as_int();
    const std::string hash = entries.take("hash").as_string();
    entries.refuse_others();
    if (bytes < 0)
        throw Error("bytes: expected a number that is not negative");
    if (hash.size() != 32 || hash.find_first_not_of("0123456789abcdef") != std::string::npos)
        throw Error("hash: expected 32 lowercase hexadecimal digits");
    return {name, {static_cast<std::uint64_t>(bytes), hash}};
}

std::vector<int> heights_from(const Value& value)
{
    std::vector<int> heights;
    for (const Value& height : value.as_list())
    {
        const std::int64_t px = height.as_int();
        if (px < 1 || px > largest_height || (!heights.empty() && px <= heights.back()))
            throw Error("expected numbers from 1 to 65536 in ascending order");
        heights.push_back(static_cast<int>(px));
    }
    if (heights.empty())
        throw Error("expected at least one height");
    return heights;
}

UvType uv_type_from(const Value& value)
{
    if (value.as_string() == "float32")
        return UvType::float32;
    if (value.as_string() == "uint16")
        return UvType::uint16;
    throw Error("expected float32 or uint16");
}

void check_format(StrictMap& entries)
{
    const Value& format = entries.take("format");
    if (!format.is_string() || format.as_string() != format_name)
        throw Error("format: not a fresco dataset, whose format is \"" + std::string(format_name) + "\"");
    const std::int64_t version = entries.take("version").as_int();
    if (version != format_version)
        throw Error(fmt::format("version: {}; this fresco reads version {}: write the dataset with the same fresco that reads it",
                                version, format_version));
    const Value& found = entries.take("conventions");
    const Value expected = conventions();
    for (const auto& [key, value] : expected.as_map())
        if (const Value* entry = found.find(key); entry == nullptr || *entry != value)
            throw Error("conventions: " + key + ": expected " + to_json(value) +
                        (entry == nullptr ? "" : ", got " + to_json(*entry)));
}

Agreement agreement_from(const Value& value)
{
    StrictMap entries(value);
    const auto number = [&](std::string_view name)
    {
        const double found = entries.take(name).as_double();
        if (!(found >= 0))
            throw Error(std::string(name) + ": expected a number that is not negative");
        return found;
    };
    const Agreement agreement{.error_before = number("error_before"),
                              .error_after = number("error_after"),
                              .median_moved_px = number("median_moved_px"),
                              .most_moved_px = number("most_moved_px")};
    entries.refuse_others();
    return agreement;
}

/// Calls `read` and says where, should it fail.
template <class Read>
auto at_place(const std::string& place, const Read& read)
{
    try
    {
        return read();
    }
    catch (const Error& error)
    {
        throw Error(place + ": " + error.what());
    }
}

Manifest manifest_from(const Value& root)
{
    StrictMap entries(root);
    check_format(entries);
    Manifest manifest;
    if (root.find("writer") != nullptr)
        manifest.writer = entries.take("writer").as_string();
    manifest.uv = at_place("uv", [&] { return uv_type_from(entries.take("uv")); });
    manifest.heights_px = at_place("heights_px", [&] { return heights_from(entries.take("heights_px")); });
    manifest.has_style = entries.take("has_style").as_bool();
    if (root.find("agreement") != nullptr)
        manifest.agreement = at_place("agreement", [&] { return agreement_from(entries.take("agreement")); });
    std::set<std::pair<std::string, std::string>> frames;
    for (const Value& value : entries.take("views").as_list())
    {
        const std::string place = fmt::format("views[{}]", manifest.views.size());
        View view = at_place(place, [&] { return view_from(value, manifest.heights_px); });
        if (!frames.emplace(view.sequence, view.frame).second)
            throw Error(place + ": " + view.sequence + "/" + view.frame + " appears twice");
        manifest.views.push_back(std::move(view));
    }
    if (manifest.views.empty())
        throw Error("views: expected at least one");
    for (const Value& value : entries.take("files").as_list())
    {
        const std::string place = fmt::format("files[{}]", manifest.files.size());
        const auto [file, is_new] = manifest.files.insert(at_place(place, [&] { return file_from(value); }));
        if (!is_new)
            throw Error(place + ": " + file->first + " appears twice");
    }
    entries.refuse_others();
    for (const std::string& name : needed_files(manifest))
        if (!manifest.files.contains(name))
            throw Error("files: " + name + " is not listed");
    return manifest;
}

}  // namespace

std::string map_name(std::size_t view, std::string_view quantity, int height_px)
{
    return fmt::format("{}{}_{}.npy", view_folder(view), quantity, height_px);
}

std::string picture_name(std::size_t view)
{
    return view_folder(view) + "color.npy";
}

std::string sensor_depth_name(std::size_t view)
{
    return view_folder(view) + "sensor_depth.npy";
}

std::vector<std::string> needed_files(const Manifest& manifest)
{
    std::vector<std::string> names{std::string(mesh_name)};
    if (manifest.has_style)
        names.emplace_back(style_name);
    for (std::size_t i = 0; i < manifest.views.size(); ++i)
    {
        names.push_back(picture_name(i));
        if (manifest.views[i].depth_unit_m)
            names.push_back(sensor_depth_name(i));
        for (const int height : manifest.heights_px)
            for (const char* quantity : {"uv", "depth", "cosine", "valid", "color"})
                names.push_back(map_name(i, quantity, height));
    }
    return names;
}

Value to_value(const Agreement& agreement)
{
    return Value::Map{{"error_before", agreement.error_before},
                      {"error_after", agreement.error_after},
                      {"median_moved_px", agreement.median_moved_px},
                      {"most_moved_px", agreement.most_moved_px}};
}

Value stamps_value(const std::map<std::string, FileStamp>& files)
{
    Value::List list;
    for (const auto& [name, stamp] : files)
        list.emplace_back(Value::Map{{"name", name}, {"bytes", stamp.bytes}, {"hash", stamp.hash}});
    return list;
}

std::string to_text(const Manifest& manifest)
{
    Value::List views;
    for (const View& view : manifest.views)
        views.push_back(to_value(view));
    Value root = Value::Map{{"format", format_name}, {"version", format_version}};
    if (!manifest.writer.empty())
        root.set("writer", manifest.writer);
    root.set("conventions", conventions());
    root.set("uv", word_of(manifest.uv));
    root.set("heights_px", Value::List(manifest.heights_px.begin(), manifest.heights_px.end()));
    root.set("has_style", manifest.has_style);
    if (manifest.agreement)
        root.set("agreement", to_value(*manifest.agreement));
    root.set("views", std::move(views));
    root.set("files", stamps_value(manifest.files));
    return to_json(root, 1) + "\n";
}

Manifest parse_manifest(std::string_view text, std::string_view source)
{
    const Value root = parse_json(text, source);
    return at_place(std::string(source), [&] { return manifest_from(root); });
}

}  // namespace fresco::dataset
