// Pictures are not decoded here, and no file is opened by tinygltf itself.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fstream>  // which tinygltf uses but does not include then

#include "gltf_file.h"

#include "file_folder.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <string_view>
#include <utility>

namespace scan_mesh
{

namespace fs = std::filesystem;
using fresco::Error;
using fresco::Value;

namespace
{

constexpr std::size_t glb_header_bytes = 12;
constexpr std::size_t chunk_header_bytes = 8;
constexpr std::uint32_t json_chunk = 0x4E4F534A;
constexpr std::uint32_t binary_chunk = 0x004E4942;

/// The lists of a document that are used; of the rest tinygltf learns nothing.
constexpr std::array<std::string_view, 11> used_entries{"asset",    "scene",    "scenes",    "nodes",       "meshes", "materials",
                                                        "textures", "samplers", "accessors", "bufferViews", "buffers"};

/// Extensions that change nothing here, or that are read.
constexpr std::array<std::string_view, 16> known_extensions{"KHR_materials_unlit",
                                                            "KHR_materials_pbrSpecularGlossiness",
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
                                                            "KHR_texture_transform",
                                                            "KHR_animation_pointer",
                                                            "KHR_node_visibility"};

std::string_view text_of(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at)
{
    if (bytes.size() < at + 4)
        throw Error("ends at byte " + std::to_string(bytes.size()) + " inside of a header: the file is cut");
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

struct Chunks
{
    std::string_view json;
    std::span<const std::byte> binary;
};

std::span<const std::byte> chunk_at(std::span<const std::byte> file, std::size_t at, std::uint32_t type, const char* name)
{
    const std::size_t length = word_at(file, at);
    if (word_at(file, at + 4) != type || length > file.size() - at - chunk_header_bytes)
        throw Error("byte " + std::to_string(at) + ": expected the " + name + " chunk, inside of the file");
    return file.subspan(at + chunk_header_bytes, length);
}

/// Splits a GLB; a glTF file is all JSON.
Chunks chunks_of(std::span<const std::byte> file)
{
    if (!text_of(file).starts_with("glTF"))
        return {text_of(file), {}};
    if (word_at(file, 4) != 2)
        throw Error("byte 4: GLB version " + std::to_string(word_at(file, 4)) +
                    "; expected 2: export the model again as glTF 2.0");
    if (word_at(file, 8) != file.size())
        throw Error("byte 8: the header says " + std::to_string(word_at(file, 8)) + " bytes, the file has " +
                    std::to_string(file.size()) + ": it is cut or damaged");
    Chunks chunks;
    const auto json = chunk_at(file, glb_header_bytes, json_chunk, "JSON");
    chunks.json = text_of(json);
    const std::size_t end = glb_header_bytes + chunk_header_bytes + json.size();
    if (end < file.size())
        chunks.binary = chunk_at(file, end, binary_chunk, "BIN");
    return chunks;
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
    if (name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression")
        way_out = "export the model without compression";
    else if (name == "KHR_texture_basisu" || name == "EXT_texture_webp" || name == "EXT_texture_avif")
        way_out = "export the model with PNG or JPEG pictures";
    throw Error("extensionsRequired: the file needs " + name + ", which is not supported; " + way_out);
}

void check_extensions(const Value& document)
{
    const Value* const required = document.find("extensionsRequired");
    if (required == nullptr)
        return;
    for (const Value& name : required->as_list())
        if (std::ranges::find(known_extensions, name.as_string()) == known_extensions.end())
            refuse_extension(name.as_string());
}

const Value::List& list_of(const Value& document, std::string_view key)
{
    static const Value::List empty;
    const Value* const list = document.find(key);
    return list == nullptr ? empty : list->as_list();
}

std::vector<GltfImage> images_of(const Value& document)
{
    std::vector<GltfImage> images;
    for (const Value& value : list_of(document, "images"))
    {
        GltfImage image;
        if (const Value* const view = value.find("bufferView"))
        {
            const std::int64_t number = view->as_int();
            if (number < 0 || number > std::numeric_limits<int>::max())
                throw Error(entry("images", images.size()) + "bufferView is not an index");
            image.buffer_view = static_cast<int>(number);
        }
        if (const Value* const uri = value.find("uri"))
            image.uri = uri->as_string();
        images.push_back(std::move(image));
    }
    return images;
}

/// Hands the contents of buffers to tinygltf, which asks for "buffer-N".
class BufferSource
{
  public:
    static constexpr std::string_view prefix = "buffer-";

    BufferSource(const fs::path& file, std::span<const std::byte> binary, std::vector<fs::path>& files_read)
        : folder_(file), binary_(binary), files_read_(files_read)
    {
    }

    /// Takes the URIs out of a document's buffers.
    Value::List take_uris(const Value::List& buffers)
    {
        Value::List result;
        for (const Value& buffer : buffers)
        {
            const Value* const uri = buffer.find("uri");
            const std::int64_t length = buffer.at("byteLength").as_int();
            if (length < 1)
                throw Error(entry("buffers", result.size()) + "byteLength is " + std::to_string(length));
            uris_.push_back(uri == nullptr ? "" : uri->as_string());
            lengths_.push_back(static_cast<std::size_t>(length));
            std::string asked(prefix);
            asked += std::to_string(result.size());
            Value::Map plain{{"byteLength", length}, {"uri", is_data_uri(uris_.back()) ? uris_.back() : asked}};
            result.emplace_back(std::move(plain));
        }
        return result;
    }

    tinygltf::FsCallbacks callbacks()
    {
        return {[](const std::string&, void*) { return true; }, [](const std::string& name, void*) { return name; },
                read_callback, nullptr, this};
    }

    /// What went wrong in a callback.
    void rethrow() const
    {
        if (failure_)
            std::rethrow_exception(failure_);
    }

  private:
    static bool read_callback(std::vector<unsigned char>* out, std::string*, const std::string& name, void* self)
    {
        auto& source = *static_cast<BufferSource*>(self);
        try
        {
            source.read(*out, name);
            return true;
        }
        catch (...)
        {
            source.failure_ = std::current_exception();
            return false;
        }
    }

    void read(std::vector<unsigned char>& out, const std::string& name)
    {
        std::size_t number = 0;
        std::from_chars(name.data() + prefix.size(), name.data() + name.size(), number);
        const std::string place = entry("buffers", number);
        std::vector<std::byte> file;
        std::span<const std::byte> bytes = binary_;
        if (!uris_.at(number).empty())
        {
            const fs::path path = folder_.find(decoded_uri(uris_[number]), place + "uri");
            files_read_.push_back(path);
            file = fresco::read_file(path);
            bytes = file;
        }
        else if (number != 0 || binary_.empty())
            throw Error(place + "there is neither a uri nor a BIN chunk");
        if (bytes.size() < lengths_[number])
            throw Error(place + "byteLength is " + std::to_string(lengths_[number]) + ", but there are " +
                        std::to_string(bytes.size()) + " bytes: the file is cut");
        const auto* const begin = reinterpret_cast<const unsigned char*>(bytes.data());
        out.assign(begin, begin + lengths_[number]);
    }

    FileFolder folder_;
    std::span<const std::byte> binary_;
    std::vector<fs::path>& files_read_;
    std::vector<std::string> uris_;
    std::vector<std::size_t> lengths_;
    std::exception_ptr failure_;
};

tinygltf::Model parsed(const Value& document, BufferSource& source)
{
    Value::Map used;
    for (const auto& [key, value] : document.as_map())
        if (key == "buffers")
            used.emplace_back(key, source.take_uris(value.as_list()));
        else if (std::ranges::find(used_entries, key) != used_entries.end())
            used.emplace_back(key, value);
    const std::string text = fresco::to_json(Value(std::move(used)));
    if (text.size() > std::numeric_limits<unsigned int>::max())
        throw Error("the JSON part has more than 4 GiB");
    tinygltf::TinyGLTF loader;
    loader.SetFsCallbacks(source.callbacks());
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
    source.rethrow();
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
            throw Error(what + " has " + std::to_string(expected - found) + " entries that are not valid");
    };
    expect(model.accessors.size(), list_of(document, "accessors").size(), "accessors");
    expect(model.nodes.size(), list_of(document, "nodes").size(), "nodes");
    expect(model.materials.size(), list_of(document, "materials").size(), "materials");
    const auto& meshes = list_of(document, "meshes");
    expect(model.meshes.size(), meshes.size(), "meshes");
    for (std::size_t i = 0; i < meshes.size(); ++i)
        expect(model.meshes[i].primitives.size(), list_of(meshes[i], "primitives").size(), entry("meshes", i) + "primitives");
}

void check_views(const tinygltf::Model& model)
{
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i)
    {
        const auto& view = model.bufferViews[i];
        if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size())
            throw Error(entry("bufferViews", i) + "buffer " + std::to_string(view.buffer) + " of " +
                        std::to_string(model.buffers.size()));
        const std::size_t size = model.buffers[static_cast<std::size_t>(view.buffer)].data.size();
        if (view.byteOffset > size || view.byteLength > size - view.byteOffset)
            throw Error(entry("bufferViews", i) + std::to_string(view.byteLength) + " bytes at " +
                        std::to_string(view.byteOffset) + " do not fit into the buffer of " + std::to_string(size));
    }
}

}  // namespace

std::string entry(const char* list, std::size_t at)
{
    return std::string(list) + "[" + std::to_string(at) + "]: ";
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
    if (!tinygltf::IsDataURI(uri) || !tinygltf::DecodeDataURI(&bytes, type, uri, 0, false))
        throw Error(place + "expected \"data:image/png;base64,…\" or \"data:image/jpeg;base64,…\"");
    const auto* const begin = reinterpret_cast<const std::byte*>(bytes.data());
    return {begin, begin + bytes.size()};
}

std::span<const unsigned char> view_bytes(const tinygltf::Model& model, std::size_t view)
{
    const auto& place = model.bufferViews.at(view);
    return std::span(model.buffers[static_cast<std::size_t>(place.buffer)].data).subspan(place.byteOffset, place.byteLength);
}

GltfFile load_gltf(const fs::path& file, std::vector<fs::path>& files_read)
{
    const auto bytes = fresco::read_file(file);
    const Chunks chunks = chunks_of(bytes);
    const Value document = fresco::parse_json(chunks.json, "JSON");
    check_version(document);
    check_extensions(document);
    BufferSource source(file, chunks.binary, files_read);
    GltfFile result{parsed(document, source), images_of(document)};
    check_counts(document, result.model);
    check_views(result.model);
    return result;
}

}  // namespace scan_mesh
