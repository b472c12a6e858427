// tinygltf decodes no picture and opens no file.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fmt/format.h>
#include <fstream>  // which tinygltf uses but does not include then

#include <fresco/gltf/compression.h>
#include <fresco/gltf/gltf_file.h>

#include <fresco/error.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

namespace fresco::gltf
{

namespace
{

constexpr std::size_t glb_header_bytes = 12;
constexpr std::size_t chunk_header_bytes = 8;
constexpr std::uint32_t json_chunk = 0x4E4F534A;
constexpr std::uint32_t binary_chunk = 0x004E4942;

/// The entries of a document that tinygltf parses. Buffers and images are read here.
constexpr std::array<std::string_view, 12> parsed_entries{"asset",     "scene",       "scenes",         "nodes",
                                                          "meshes",    "materials",   "textures",       "samplers",
                                                          "accessors", "bufferViews", "extensionsUsed", "extensionsRequired"};

/// Entries that are an index or a code, and entries that are a number of bytes or rows.
constexpr std::array<std::string_view, 14> index_keys{"buffer",   "bufferView", "componentType", "index",   "indices",
                                                      "material", "mesh",       "mode",          "sampler", "scene",
                                                      "skin",     "source",     "texCoord",      "target"};
constexpr std::array<std::string_view, 4> size_keys{"byteLength", "byteOffset", "byteStride", "count"};
/// Lists and maps of indices.
constexpr std::array<std::string_view, 4> index_lists{"attributes", "children", "nodes", "targets"};
/// Entries of other extensions are unknown.
constexpr std::array<std::string_view, 8> read_extensions{"KHR_materials_pbrSpecularGlossiness",
                                                          "KHR_texture_transform",
                                                          "EXT_meshopt_compression",
                                                          "KHR_draco_mesh_compression",
                                                          "KHR_gaussian_splatting",
                                                          "EXT_texture_webp",
                                                          "EXT_texture_avif",
                                                          "EXT_mesh_gpu_instancing"};

/// Others that a file may require, because they change nothing here.
constexpr std::array<std::string_view, 15> passed_extensions{"KHR_materials_unlit",
                                                             "KHR_materials_variants",
                                                             "KHR_materials_specular",
                                                             "KHR_materials_ior",
                                                             "KHR_materials_clearcoat",
                                                             "KHR_materials_sheen",
                                                             "KHR_materials_transmission",
                                                             "KHR_materials_volume",
                                                             "KHR_materials_iridescence",
                                                             "KHR_materials_anisotropy",
                                                             "KHR_materials_emissive_strength",
                                                             "KHR_lights_punctual",
                                                             "KHR_mesh_quantization",
                                                             "KHR_animation_pointer",
                                                             "KHR_node_visibility"};

template <std::size_t N>
bool contains(const std::array<std::string_view, N>& names, std::string_view name)
{
    return std::ranges::find(names, name) != names.end();
}

std::string_view text_of(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at)
{
    if (bytes.size() < at + 4)
        throw Error(fmt::format("ends at byte {} inside a header: the file is truncated", bytes.size()));
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

std::span<const std::byte> chunk_at(std::span<const std::byte> file, std::size_t at, std::uint32_t type, const char* name)
{
    const std::size_t length = word_at(file, at);
    if (word_at(file, at + 4) != type || length > file.size() - at - chunk_header_bytes)
        throw Error(fmt::format("byte {}: expected the {} chunk, inside the file", at, name));
    return file.subspan(at + chunk_header_bytes, length);
}

void check_version(const Value& document)
{
    const Value* const asset = document.find("asset");
    const Value* const version = asset == nullptr ? nullptr : asset->find("version");
    if (version == nullptr || !version->is_string())
        throw Error("asset.version is missing: this is not a glTF file");
    if (!version->as_string().starts_with("2."))
        throw Error("asset.version is " + version->as_string() + "; expected 2.0: export the model again as glTF 2.0");
}

[[noreturn]] void refuse_extension(const std::string& name)
{
    std::string way_out = "export the model without it";
    if (name == "KHR_texture_basisu")
        way_out = "export the model with PNG or JPEG pictures";
    throw Error("extensionsRequired: the file needs " + name + ", which is not supported; " + way_out);
}

void check_extensions(const Value& document)
{
    const Value* const required = document.find("extensionsRequired");
    if (required == nullptr)
        return;
    for (const Value& name : required->as_list())
        if (!contains(read_extensions, name.as_string()) && !contains(passed_extensions, name.as_string()))
            refuse_extension(name.as_string());
}

const Value::List& list_of(const Value& document, std::string_view key)
{
    static const Value::List empty;
    const Value* const list = document.find(key);
    return list == nullptr ? empty : list->as_list();
}

constexpr std::string_view meshopt = "EXT_meshopt_compression";
constexpr std::string_view draco = "KHR_draco_mesh_compression";

/// tinygltf takes an index beyond 32 bits for its lower half, and a number of another kind for one that is not there.
void check_numbers(const Value& value, std::string_view key, const std::string& place)
{
    const bool is_size = contains(size_keys, key);
    const bool is_index = contains(index_keys, key) || (value.is_number() && contains(index_lists, key));
    const std::int64_t greatest = is_size ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int32_t>::max();
    if (is_size || is_index)
    {
        if (!value.is_int() || value.as_int() < 0 || value.as_int() > greatest)
            throw Error(
                fmt::format("{}: expected a whole number from 0 to {}, not {}", place, greatest, to_json(value).substr(0, 60)));
    }
    else if (value.is_list())
        for (std::size_t i = 0; i < value.as_list().size(); ++i)
            check_numbers(value.as_list()[i], key, fmt::format("{}[{}]", place, i));
    else if (value.is_map())
        for (const auto& [name, inner] : value.as_map())
            if (name != "extras" && !(key == meshopt && name == "mode") &&
                (key != "extensions" || contains(read_extensions, name)))
            {
                const bool is_list = key == "attributes" || key == "targets" || (key == "sparse" && inner.is_map());
                // tinygltf has 32 bits for all numbers of sparse accessors.
                check_numbers(inner, is_list ? key : key == "sparse" ? "index" : std::string_view(name), place + "." + name);
            }
}

std::string text_or_none(const Value& map, std::string_view key)
{
    const Value* const found = map.find(key);
    return found == nullptr ? "" : found->as_string();
}

std::vector<GltfImage> images_of(const Value& document)
{
    std::vector<GltfImage> images;
    for (const Value& value : list_of(document, "images"))
    {
        const Value* const view = value.find("bufferView");
        images.push_back({view == nullptr ? -1 : static_cast<int>(view->as_int()), text_or_none(value, "uri")});
    }
    return images;
}

tinygltf::Buffer buffer_of(std::span<const std::byte> bytes)
{
    const auto* const begin = reinterpret_cast<const unsigned char*>(bytes.data());
    tinygltf::Buffer buffer;
    buffer.data.assign(begin, begin + bytes.size());
    return buffer;
}

std::vector<tinygltf::Buffer> buffers_of(const Value& document, std::span<const std::byte> binary, const ReadBuffer& read_beside)
{
    std::vector<tinygltf::Buffer> buffers;
    for (const Value& value : list_of(document, "buffers"))
    {
        const std::string place = entry("buffers", buffers.size());
        const std::string uri = text_or_none(value, "uri");
        const bool is_chunk = uri.empty() && buffers.empty() && !binary.empty();
        const auto length = static_cast<std::size_t>(value.at("byteLength").as_int());
        // Stands for what is compressed in other buffers.
        const Value* const compression = extension_of(value, meshopt);
        if (uri.empty() && !is_chunk && compression != nullptr && compression->find("fallback") != nullptr)
        {
            buffers.emplace_back();
            continue;
        }
        if (uri.empty() && !is_chunk)
            throw Error(place + "expected a uri or a BIN chunk");
        std::vector<std::byte> outside;
        if (!uri.empty())
            outside = is_data_uri(uri) ? data_uri_bytes(uri, place) : read_beside(uri, place);
        const std::span<const std::byte> bytes = uri.empty() ? binary : outside;
        if (length == 0 || bytes.size() < length)
            throw Error(
                fmt::format("{}byteLength is {}, but there are {} bytes: the file is truncated", place, length, bytes.size()));
        buffers.push_back(buffer_of(bytes.first(length)));
    }
    return buffers;
}

tinygltf::Model parsed(const Value& document)
{
    Value::Map used;
    for (const auto& [key, value] : document.as_map())
        if (contains(parsed_entries, key))
            used.emplace_back(key, value);
    // tinygltf wants a view for indices at once.
    if (const auto meshes = std::ranges::find(used, "meshes", &Value::Map::value_type::first); meshes != used.end())
        for (Value& mesh : meshes->second.as_list())
            if (Value* const primitives = mesh.find("primitives"))
                for (Value& primitive : primitives->as_list())
                    if (extension_of(primitive, draco) != nullptr)
                        std::erase_if(primitive.as_map(), [](const auto& each) { return each.first == "indices"; });
    const std::string text = to_json(Value(std::move(used)));
    if (text.size() > std::numeric_limits<unsigned int>::max())
        throw Error("the JSON part has more than 4 GiB");
    tinygltf::TinyGLTF loader;
    tinygltf::Model model;
    std::string errors;
    std::string warnings;
    bool good = false;
    try
    {
        good = loader.LoadASCIIFromString(&model, &errors, &warnings, text.data(), static_cast<unsigned int>(text.size()), "");
    }
    catch (const std::exception& error)
    {
        errors = error.what();
    }
    if (!good || !errors.empty())
    {
        std::ranges::replace(errors, '\n', ' ');
        throw Error("not valid glTF: " + errors);
    }
    return model;
}

/// tinygltf leaves out what it cannot parse.
void check_counts(const Value& document, const tinygltf::Model& model)
{
    const auto expect = [](std::size_t found, std::size_t expected, const std::string& what)
    {
        if (found != expected)
            throw Error(fmt::format("{} has {} invalid entries", what, expected - found));
    };
    expect(model.accessors.size(), list_of(document, "accessors").size(), "accessors");
    expect(model.nodes.size(), list_of(document, "nodes").size(), "nodes");
    expect(model.materials.size(), list_of(document, "materials").size(), "materials");
    const auto& meshes = list_of(document, "meshes");
    expect(model.meshes.size(), meshes.size(), "meshes");
    for (std::size_t i = 0; i < meshes.size(); ++i)
        expect(model.meshes[i].primitives.size(), list_of(meshes[i], "primitives").size(), entry("meshes", i) + "primitives");
}

/// The bytes of a buffer that an entry names, which begins messages as `place`.
std::span<const unsigned char> bytes_of(const tinygltf::Model& model, int buffer, std::size_t offset, std::size_t length,
                                        const std::string& place)
{
    if (buffer < 0 || static_cast<std::size_t>(buffer) >= model.buffers.size())
        throw Error(fmt::format("{}buffer {} of {}", place, buffer, model.buffers.size()));
    const std::span<const unsigned char> all(model.buffers[static_cast<std::size_t>(buffer)].data);
    if (offset > all.size() || length > all.size() - offset)
        throw Error(fmt::format("{}{} bytes at {} do not fit into the buffer of {}", place, length, offset, all.size()));
    return all.subspan(offset, length);
}

std::size_t size_or_zero(const Value& map, std::string_view key)
{
    const Value* const found = map.find(key);
    return found == nullptr ? 0 : static_cast<std::size_t>(found->as_int());
}

/// Unpacks what is compressed; a few bytes that many entries name could take any amount of memory, so they are counted.
class Unpacking
{
  public:
    Unpacking(const Value& document, tinygltf::Model& model) : document_(document), model_(model)
    {
        for (const auto& buffer : model.buffers)
            left_ += buffer.data.size();
    }

    void views()
    {
        const auto& all = list_of(document_, "bufferViews");
        for (std::size_t i = 0; i < all.size(); ++i)
            if (const Value* const form = extension_of(all[i], meshopt))
            {
                const std::size_t offset = size_or_zero(*form, "byteOffset");
                const std::size_t length = size_or_zero(*form, "byteLength");
                const auto buffer = static_cast<int>(form->at("buffer").as_int());
                const std::string place = fmt::format("{}{}: ", entry("bufferViews", i), meshopt);
                const auto stream = bytes_of(model_, buffer, offset, length, place);
                take(length, place);
                const auto rows =
                    meshopt_decoded(std::as_bytes(stream), *form, fmt::format("{}byte {} of buffer {}: ", place, offset, buffer));
                tinygltf::BufferView& view = model_.bufferViews.at(i);
                check_plain_form(view, rows.size(), i);
                view.buffer = static_cast<int>(model_.buffers.size());
                view.byteOffset = 0;
                view.byteLength = rows.size();
                model_.buffers.push_back(buffer_of(rows));
            }
    }

    void primitives()
    {
        const auto& meshes = list_of(document_, "meshes");
        for (std::size_t i = 0; i < meshes.size(); ++i)
        {
            const auto& all = list_of(meshes[i], "primitives");
            for (std::size_t k = 0; k < all.size(); ++k)
                if (const Value* const form = extension_of(all[k], draco))
                {
                    tinygltf::Primitive& primitive = model_.meshes[i].primitives[k];
                    if (const Value* const indices = all[k].find("indices"))
                        primitive.indices = static_cast<int>(indices->as_int());
                    unpack(primitive, *form, entry("meshes", i) + entry("primitives", k));
                }
        }
    }

  private:
    void check_plain_form(const tinygltf::BufferView& view, std::size_t bytes, std::size_t number) const
    {
        if (view.byteLength != bytes)
            throw Error(fmt::format("{}byteLength: expected count x byteStride, {}", entry("bufferViews", number), bytes));
        const auto& required = model_.extensionsRequired;
        if (bytes_of(model_, view.buffer, 0, 0, entry("bufferViews", number)).data() == nullptr &&
            std::ranges::find(required, meshopt) == required.end())
            throw Error(fmt::format("extensionsRequired: expected {}, which bufferViews use", meshopt));
    }

    void unpack(tinygltf::Primitive& primitive, const Value& form, const std::string& place)
    {
        const auto view = static_cast<std::size_t>(form.at("bufferView").as_int());
        if (view >= model_.bufferViews.size())
            throw Error(fmt::format("{}bufferView {} of {}", place, view, model_.bufferViews.size()));
        // Primitives of several materials or meshes may share all that they have.
        if (!unpacked_.insert({view, primitive.indices, primitive.attributes}).second)
        {
            primitive.mode = TINYGLTF_MODE_TRIANGLES;
            return;
        }
        const auto stream = view_bytes(model_, view);
        take(stream.size(), place);
        try
        {
            // The model's buffers move while some are added.
            const std::vector<unsigned char> copy(stream.begin(), stream.end());
            unpack_draco(model_, primitive, std::as_bytes(std::span(copy)), form);
        }
        catch (const Error& error)
        {
            throw Error(place + error.what());
        }
    }

    void take(std::size_t bytes, const std::string& place)
    {
        if (bytes > left_)
            throw Error(place + "compressed parts overlap; export the model again");
        left_ -= bytes;
    }

    const Value& document_;
    tinygltf::Model& model_;
    std::size_t left_ = 0;
    std::set<std::tuple<std::size_t, int, std::map<std::string, int>>> unpacked_;
};

void check_views(const tinygltf::Model& model)
{
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i)
    {
        const auto& view = model.bufferViews[i];
        bytes_of(model, view.buffer, view.byteOffset, view.byteLength, entry("bufferViews", i));
    }
}

/// The parts of a GLB.
struct Chunks
{
    std::string_view json;
    std::span<const std::byte> binary;
};

/// Splits a GLB; any other file is all JSON. Throws Error naming the offset.
Chunks chunks_of(std::span<const std::byte> file)
{
    if (!text_of(file).starts_with("glTF"))
        return {text_of(file), {}};
    if (word_at(file, 4) != 2)
        throw Error(fmt::format("byte 4: GLB version {}; expected 2: export the model again as glTF 2.0", word_at(file, 4)));
    if (word_at(file, 8) != file.size())
        throw Error(fmt::format("byte 8: the header says {} bytes, the file has {}: it is truncated or damaged", word_at(file, 8),
                                file.size()));
    Chunks chunks;
    const auto json = chunk_at(file, glb_header_bytes, json_chunk, "JSON");
    chunks.json = text_of(json);
    const std::size_t end = glb_header_bytes + chunk_header_bytes + json.size();
    if (end < file.size())
        chunks.binary = chunk_at(file, end, binary_chunk, "BIN");
    return chunks;
}

}  // namespace

FileFormat glb_format()
{
    return {.name = "a GLB model", .extensions = {".glb"}, .begins = {"glTF"}, .length_at = 8, .length_bytes = 4};
}

FileFormat gltf_format()
{
    FileFormat format = json_format();
    format.name = "a glTF model";
    format.extensions = {".gltf"};
    return format;
}

std::string entry(const char* list, std::size_t at)
{
    return fmt::format("{}[{}]: ", list, at);
}

std::string decoded_uri(std::string_view uri)
{
    std::string name;
    for (std::size_t i = 0; i < uri.size(); ++i)
    {
        unsigned code = 0;
        const char* const digits = uri.data() + i + 1;
        if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2)
        {
            name += static_cast<char>(code);
            i += 2;
        }
        else
            name += uri[i];
    }
    return name;
}

bool is_data_uri(const std::string& uri)
{
    return uri.starts_with("data:");
}

std::vector<std::byte> data_uri_bytes(const std::string& uri, const std::string& place)
{
    std::vector<unsigned char> bytes;
    std::string type;
    // tinygltf knows two kinds of pictures; all are the same base64.
    std::string known = uri;
    for (const std::string_view kind : {"data:image/webp;", "data:image/avif;"})
        if (uri.starts_with(kind))
            known.replace(0, kind.size(), "data:image/png;");
    if (!tinygltf::IsDataURI(known) || !tinygltf::DecodeDataURI(&bytes, type, known, 0, false))
        throw Error(place + "expected \"data:image/png;base64,…\" (or jpeg, webp, avif) or, for buffers, "
                            "\"data:application/octet-stream;base64,…\"");
    const auto* const begin = reinterpret_cast<const std::byte*>(bytes.data());
    return {begin, begin + bytes.size()};
}

std::span<const unsigned char> view_bytes(const tinygltf::Model& model, std::size_t view)
{
    const auto& place = model.bufferViews.at(view);
    return std::span(model.buffers[static_cast<std::size_t>(place.buffer)].data).subspan(place.byteOffset, place.byteLength);
}

GltfFile load_gltf(std::span<const std::byte> file, const ReadBuffer& read_beside)
{
    const Chunks chunks = chunks_of(file);
    // Some exporters fill the JSON chunk up with NULs, not with spaces.
    Value document = parse_json(chunks.json.substr(0, chunks.json.find_last_not_of('\0') + 1), "JSON");
    check_version(document);
    check_extensions(document);
    for (const auto& [key, value] : document.as_map())
        if (contains(parsed_entries, key) || key == "buffers" || key == "images")
            check_numbers(value, key, key);
    GltfFile result{parsed(document), images_of(document), {}};
    check_counts(document, result.model);
    result.model.buffers = buffers_of(document, chunks.binary, read_beside);
    Unpacking unpacking(document, result.model);
    unpacking.views();
    check_views(result.model);
    unpacking.primitives();
    result.document = std::move(document);
    return result;
}

namespace
{

std::size_t size_of_component(int type)
{
    const bool is_known = type == TINYGLTF_COMPONENT_TYPE_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                          type == TINYGLTF_COMPONENT_TYPE_SHORT || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT || type == TINYGLTF_COMPONENT_TYPE_FLOAT;
    return is_known ? static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type))) : 0;
}

}  // namespace

double AccessorRows::at(std::size_t row, std::size_t component) const
{
    const unsigned char* const from = first + row * stride + component * size_of_component(component_type);
    return with_component(component_type,
                          [&]<class T>(T value)
                          {
                              std::memcpy(&value, from, sizeof value);
                              const auto number = static_cast<double>(value);
                              if constexpr (std::is_integral_v<T> && sizeof value < 4)
                                  return normalized ? std::max(number / std::numeric_limits<T>::max(), -1.0) : number;
                              else
                                  return number;
                          });
}

namespace
{

/// Returns where `count` rows of `packed` bytes begin in a view; sets `stride` to the bytes from one to the next. Throws Error
/// beginning with `place` if they do not fit.
const unsigned char* rows_in_view(const tinygltf::Model& model, int view, std::size_t offset, std::size_t count,
                                  std::size_t packed, const std::string& place, std::size_t& stride)
{
    if (view < 0 || static_cast<std::size_t>(view) >= model.bufferViews.size())
        throw Error(place + "it has no valid bufferView, so no data");
    const auto number = static_cast<std::size_t>(view);
    const std::size_t of_view = model.bufferViews[number].byteStride;
    stride = of_view == 0 ? packed : of_view;
    const auto bytes = view_bytes(model, number);
    const bool fits = count > 0 && stride >= packed && offset <= bytes.size() && packed <= bytes.size() - offset &&
                      count - 1 <= (bytes.size() - offset - packed) / stride;
    if (!fits)
        throw Error(fmt::format("{}{} rows of {} bytes at byte {} do not fit into the bufferView of {} bytes", place, count,
                                packed, offset, bytes.size()));
    return bytes.data() + offset;
}

/// Gives `rows` a copy of its rows, zeros where it has none, in which those of a sparse accessor are replaced.
void replace_rows(const tinygltf::Model& model, const tinygltf::Accessor& source, std::size_t packed, const std::string& place,
                  AccessorRows& rows)
{
    const auto& sparse = source.sparse;
    AccessorRows indices;
    indices.component_type = sparse.indices.componentType;
    if (indices.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
        indices.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        indices.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        throw Error(place + "expected unsigned integers as indices");
    const auto count = static_cast<std::size_t>(sparse.count);
    indices.first = rows_in_view(model, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset), count,
                                 size_of_component(indices.component_type), place + "indices: ", indices.stride);
    std::size_t stride = 0;
    const auto* const values = rows_in_view(model, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                                            count, packed, place + "values: ", stride);
    std::size_t file_bytes = 0;
    for (const auto& buffer : model.buffers)
        file_bytes += buffer.data.size();
    if (rows.count > file_bytes)
        throw Error(fmt::format("{}{} rows in a file of {} bytes", place, rows.count, file_bytes));
    const auto all = std::make_shared<std::vector<unsigned char>>(rows.count * packed);
    for (std::size_t i = 0; i < rows.count && rows.first != nullptr; ++i)
        std::memcpy(all->data() + i * packed, rows.first + i * rows.stride, packed);
    double before = -1;
    for (std::size_t i = 0; i < count; ++i)
    {
        const double index = indices.at(i, 0);
        if (index <= before || index >= static_cast<double>(rows.count))
            throw Error(fmt::format("{}index {} is {}; expected increasing ones below {}", place, i, index, rows.count));
        std::memcpy(all->data() + static_cast<std::size_t>(index) * packed, values + i * stride, packed);
        before = index;
    }
    rows.first = all->data();
    rows.stride = packed;
    rows.copy = all;
}

}  // namespace

AccessorRows accessor_rows(const tinygltf::Model& model, int accessor, std::size_t least, std::size_t most)
{
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size())
        throw Error(fmt::format("accessor {} of {}", accessor, model.accessors.size()));
    const auto number = static_cast<std::size_t>(accessor);
    const auto& source = model.accessors[number];
    const auto expect = [&](bool good, const std::string& what)
    {
        if (!good)
            throw Error(entry("accessors", number) + what);
    };
    const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(source.type));
    AccessorRows rows;
    rows.components = static_cast<std::size_t>(std::max(components, 0));
    expect(rows.components >= least && rows.components <= most && source.type != TINYGLTF_TYPE_MAT2,
           fmt::format("expected {} to {} components", least, most));
    rows.component_type = source.componentType;
    const std::size_t packed = rows.components * size_of_component(source.componentType);
    expect(packed > 0, fmt::format("componentType {} is not supported", source.componentType));
    rows.normalized = source.normalized;
    rows.count = source.count;
    if (!source.sparse.isSparse || source.bufferView >= 0)
        rows.first = rows_in_view(model, source.bufferView, source.byteOffset, rows.count, packed, entry("accessors", number),
                                  rows.stride);
    if (source.sparse.isSparse)
        replace_rows(model, source, packed, entry("accessors", number) + "sparse: ", rows);
    return rows;
}

std::vector<std::uint32_t> triangle_indices(const tinygltf::Model& model, int indices, int mode, std::size_t vertex_count)
{
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN)
        return {};
    std::vector<std::uint32_t> corners;
    if (indices < 0)
    {
        corners.resize(vertex_count);
        std::iota(corners.begin(), corners.end(), 0U);
    }
    else
    {
        const AccessorRows rows = accessor_rows(model, indices, 1, 1);
        const std::string place = entry("accessors", static_cast<std::size_t>(indices));
        if (rows.normalized || (rows.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
                                rows.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
                                rows.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT))
            throw Error(place + "expected unsigned integers as indices");
        corners.reserve(rows.count);
        for (std::size_t i = 0; i < rows.count; ++i)
        {
            corners.push_back(static_cast<std::uint32_t>(rows.at(i, 0)));
            if (corners.back() >= vertex_count)
                throw Error(fmt::format("{}index {} names vertex {} of {}", place, i, corners.back(), vertex_count));
        }
    }
    if (mode == TINYGLTF_MODE_TRIANGLES)
    {
        if (corners.size() % 3 != 0)
            throw Error(fmt::format("a primitive of triangles has {} corners; expected a multiple of 3", corners.size()));
        return corners;
    }
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 2; i < corners.size(); ++i)
    {
        const bool is_fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
        const bool is_turned = !is_fan && i % 2 == 1;
        const std::uint32_t first = is_fan ? corners[0] : corners[i - 2];
        triangles.insert(triangles.end(), {first, corners[is_turned ? i : i - 1], corners[is_turned ? i - 1 : i]});
    }
    return triangles;
}

}  // namespace fresco::gltf
