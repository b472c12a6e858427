#include <fresco/dataset/manifest.h>

#include <fresco/frames.h>
#include <fresco/value.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <utility>

namespace fresco::dataset
{
namespace
{

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
    return fmt::format("views/{:06}/", view);
}

bool is_part(std::string_view part)
{
    const auto bad = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127 || c == '/' || c == '\\'; };
    return !part.empty() && part != "." && part != ".." && std::ranges::none_of(part, bad);
}

/// A text that can be one part of a path.
std::string part_from(const JsonPlace& place)
{
    if (!is_part(place.text()))
        place.fail(to_json(place.value()) + " cannot be part of a file's name");
    return place.text();
}

/// A name that leads to a file below the folder it is relative to.
std::string name_from(const JsonPlace& place)
{
    const std::string& name = place.text();
    bool good = name != manifest_name;
    for (std::size_t start = 0; good && start <= name.size();)
    {
        const std::size_t end = std::min(name.find('/', start), name.size());
        good = is_part(std::string_view(name).substr(start, end - start));
        start = end + 1;
    }
    if (!good)
        place.fail(to_json(place.value()) + " is not a file inside the dataset's folder");
    return name;
}

Value to_value(const View& view)
{
    return Value::Map{{"sequence", view.sequence},
                      {"frame", view.frame},
                      {"number", view.number},
                      {"color_camera", to_value(view.color)},
                      {"depth_camera", to_value(view.depth)},
                      {"depth_unit_m", view.depth_unit_m ? Value(*view.depth_unit_m) : Value()},
                      {"sharpness", view.sharpness},
                      {"valid_pixels", Value::List(view.valid_pixels.begin(), view.valid_pixels.end())}};
}

View view_from(const JsonPlace& place, const std::vector<int>& heights_px)
{
    place.has_only({"sequence", "frame", "number", "color_camera", "depth_camera", "depth_unit_m", "sharpness", "valid_pixels"});
    View view;
    view.sequence = part_from(place["sequence"]);
    view.frame = part_from(place["frame"]);
    view.number = place["number"].integer();
    view.color = camera_from(place["color_camera"]);
    view.depth = camera_from(place["depth_camera"]);
    if (const JsonPlace unit = place["depth_unit_m"]; !unit.value().is_null())
        view.depth_unit_m = unit.number();
    if (view.depth_unit_m && !(*view.depth_unit_m > 0))
        place.fail("depth_unit_m", "expected a number above 0, or null");
    view.sharpness = place["sharpness"].amount();
    const JsonPlace counts = place["valid_pixels"];
    for (const JsonPlace& count : counts.list())
        view.valid_pixels.push_back(count.integer());
    if (view.valid_pixels.size() != heights_px.size())
        counts.fail(fmt::format("{} numbers; expected one per height, {}", view.valid_pixels.size(), heights_px.size()));
    for (std::size_t i = 0; i < heights_px.size(); ++i)
    {
        const std::int64_t most = std::int64_t{heights_px[i]} * view.color.intrinsics.width_at(heights_px[i]);
        if (view.valid_pixels[i] < 0 || view.valid_pixels[i] > most)
            counts.fail(fmt::format("{} of the {} pixels at {} px", view.valid_pixels[i], most, heights_px[i]));
    }
    return view;
}

std::pair<std::string, FileStamp> file_from(const JsonPlace& place)
{
    place.has_only({"name", "bytes", "hash"});
    const std::string name = name_from(place["name"]);
    const std::int64_t bytes = place["bytes"].integer(0);
    const std::string hash = place["hash"].text();
    if (hash.size() != 32 || hash.find_first_not_of("0123456789abcdef") != std::string::npos)
        place.fail("hash", "expected 32 lowercase hexadecimal digits");
    return {name, {static_cast<std::uint64_t>(bytes), hash}};
}

std::vector<int> heights_from(const JsonPlace& place)
{
    std::vector<int> heights;
    for (const JsonPlace& height : place.list())
    {
        const std::int64_t px = height.integer();
        if (px < 1 || px > largest_height || (!heights.empty() && px <= heights.back()))
            place.fail("expected numbers from 1 to 65536 in ascending order");
        heights.push_back(static_cast<int>(px));
    }
    if (heights.empty())
        place.fail("expected at least one height");
    return heights;
}

UvType uv_type_from(const JsonPlace& place)
{
    if (place.text() == "float32")
        return UvType::float32;
    if (place.text() == "uint16")
        return UvType::uint16;
    place.fail("expected float32 or uint16");
}

void check_format(const JsonPlace& whole)
{
    const JsonPlace format = whole["format"];
    if (format.value() != Value(format_name))
        format.fail("not a fresco dataset, whose format is \"" + std::string(format_name) + "\"");
    const std::int64_t version = whole["version"].integer();
    if (version != format_version)
        whole.fail("version",
                   fmt::format("{}; this fresco reads version {}: write the dataset with the same fresco that reads it", version,
                               format_version));
    const JsonPlace found = whole["conventions"];
    const Value expected = conventions();
    for (const auto& [key, value] : expected.as_map())
        if (const JsonPlace entry = found[key]; entry.value() != value)
            entry.fail("expected " + to_json(value) + ", got " + to_json(entry.value()));
}

Agreement agreement_from(const JsonPlace& place)
{
    place.has_only({"error_before", "error_after", "median_moved_px", "most_moved_px"});
    return {.error_before = place["error_before"].amount(),
            .error_after = place["error_after"].amount(),
            .median_moved_px = place["median_moved_px"].amount(),
            .most_moved_px = place["most_moved_px"].amount()};
}

Manifest manifest_from(const JsonPlace& whole)
{
    check_format(whole);
    whole.has_only(
        {"format", "version", "conventions", "writer", "uv", "heights_px", "has_style", "agreement", "views", "files"});
    Manifest manifest;
    if (const auto writer = whole.find("writer"))
        manifest.writer = writer->text();
    manifest.uv = uv_type_from(whole["uv"]);
    manifest.heights_px = heights_from(whole["heights_px"]);
    manifest.has_style = whole["has_style"].flag();
    if (const auto agreement = whole.find("agreement"))
        manifest.agreement = agreement_from(*agreement);
    std::set<std::pair<std::string, std::string>> frames;
    for (const JsonPlace& place : whole["views"].list())
    {
        View view = view_from(place, manifest.heights_px);
        if (!frames.emplace(view.sequence, view.frame).second)
            place.fail(view.sequence + "/" + view.frame + " appears twice");
        manifest.views.push_back(std::move(view));
    }
    if (manifest.views.empty())
        whole.fail("views", "expected at least one");
    for (const JsonPlace& place : whole["files"].list())
        if (const auto [file, is_new] = manifest.files.insert(file_from(place)); !is_new)
            place.fail(file->first + " appears twice");
    for (const std::string& name : needed_files(manifest))
        if (!manifest.files.contains(name))
            whole.fail("files", name + " is not listed");
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
    root.set("uv", manifest.uv == UvType::float32 ? "float32" : "uint16");
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
    return manifest_from(JsonPlace(root, std::string(source)));
}

}  // namespace fresco::dataset
