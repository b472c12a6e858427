#include <fresco/evaluation/figures_file.h>

#include <fresco/files_io.h>

#include <filesystem>

namespace fresco::evaluation
{

Files write_figures(const ArtifactFolder& folder, const std::string& path, const Value& figures)
{
    const auto file = folder.path / path;
    std::filesystem::create_directories(file.parent_path());
    write_file(file, to_json(figures, 1) + "\n");
    Files made;
    made.names = {path};
    return made;
}

}  // namespace fresco::evaluation
