#include "peer_blender.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <sys/wait.h>
#include <vector>

namespace bench
{
namespace
{

namespace fs = std::filesystem;

constexpr int most_seconds = 900;

template <class T>
void write_values(const fs::path& file, const std::vector<T>& values)
{
    fresco::write_file(file, std::as_bytes(std::span(values)));
}

template <class T>
std::vector<T> read_values(const fs::path& file)
{
    const auto bytes = fresco::read_file(file);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}

/// Of the last operator.
double seconds = 0;

fresco::Mesh through_blender(const fresco::Mesh& mesh, const std::string& task)
{
    const fresco::testing::TemporaryFolder folder;
    write_values(folder.path() / "positions", mesh.positions);
    write_values(folder.path() / "triangles", mesh.triangles);
    const std::string command = "timeout " + std::to_string(most_seconds) +
                                " blender --background --factory-startup --python '" FRESCO_BLENDER_SCRIPT "' -- '" +
                                folder.path().string() + "' " + task + " >'" + folder.path().string() + "/log' 2>&1";
    const int status = std::system(command.c_str());
    if (!fs::exists(folder.path() / "seconds"))
    {
        const bool late = WIFEXITED(status) && WEXITSTATUS(status) == 124;
        const std::string log = fresco::read_text_file(folder.path() / "log");
        throw fresco::Error(late ? "not done after " + std::to_string(most_seconds) + " s"
                                 : "Blender failed: " + log.substr(log.size() - std::min<std::size_t>(log.size(), 400)));
    }
    seconds = std::stod(fresco::read_text_file(folder.path() / "seconds"));
    fresco::Mesh result;
    result.positions = read_values<fresco::Vec3f>(folder.path() / "positions");
    result.triangles = read_values<decltype(result.triangles)::value_type>(folder.path() / "triangles");
    if (fs::exists(folder.path() / "texcoords"))
        result.texcoords = read_values<fresco::Vec2f>(folder.path() / "texcoords");
    return result;
}

}  // namespace

bool has_blender()
{
    static const bool has = std::system("blender --version >/dev/null 2>&1") == 0;
    return has;
}

Decimation blender_decimation()
{
    return {"Blender",
            [](const fresco::Mesh& mesh, std::size_t target, fresco::Progress&)
            {
                const double share = static_cast<double>(target) / static_cast<double>(mesh.triangles.size());
                return through_blender(mesh, "decimate " + std::to_string(share));
            },
            [] { return seconds; }};
}

AtlasMaker blender_atlas()
{
    return {"Blender smart project",
            [](const fresco::Mesh& mesh, int size_px, fresco::Progress&)
            { return through_blender(mesh, "unwrap " + std::to_string(size_px)); },
            [] { return seconds; }};
}

}  // namespace bench
