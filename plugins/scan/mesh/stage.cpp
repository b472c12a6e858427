#include "blender.h"
#include "file_model.h"
#include "world_mesh.h"

#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/regions/regions.h>
#include <fresco/stage.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace
{

class ScanMesh final : public fresco::Stage
{
    fresco::Option<fresco::InputFile> path{this, "path", fresco::required, fresco::formats(formats()), "Mesh or model"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Meters per unit of the file"};
    fresco::Option<std::string> axes{this, "axes", "x y z",
                                     "Axes of the file that become the world's x, y and z; \"x -z y\" turns y up into z up"};
    fresco::Option<std::vector<double>> transform{
        this, "transform", std::vector<double>{},
        "Rigid 4x4 transform after unit_m and axes: 16 numbers, row by row, in meters; empty: none"};
    fresco::Option<std::string> materials{this, "materials", "read", fresco::one_of({"read", "skip"}),
                                          "read: go on without missing materials and pictures, with warnings; skip: ignore "
                                          "all that the file names"};
    fresco::Slot<fresco::ImageIo> images{this, fresco::optional, "Checks the pictures of a model; none: no check"};

    fresco::Input<fresco::Frames> frames{this, "frames", fresco::optional,
                                         "Frames of the same world: far from 0, the mesh is stored less the same offset"};
    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The surface in the world"};
    fresco::Output<fresco::Model> model{this, "model", "The same surface with its materials and pictures"};
    fresco::Output<fresco::Regions> objects{this, "objects",
                                            "Regions of that mesh: glTF's nodes, or an OBJ's objects and groups"};

    void run(fresco::RunContext& run) override
    {
        const auto rotation = scan_mesh::axes_rotation(*axes);
        const auto world_from_file = transform->empty() ? fresco::RigidTransform{}
                                                        : fresco::recordings::rigid_transform(*transform, "option \"transform\"");
        auto read = read_model(run);
        for (const auto& file : read.files_read)
            run.reads_file(file);
        for (const auto& pattern : read.looked_for)
            fresco::recordings::looks_for(pattern, run);
        const auto of_model = [&](const std::string& text)
        { return text.starts_with(path->path.string()) ? text : path->path.filename().string() + ": " + text; };
        for (const std::string& message : read.messages)
            run.message(of_model(message));
        for (const std::string& warning : read.warnings)
            run.warning(of_model(warning));
        fresco::Mesh& surface = read.mesh;
        auto& positions = read.report.positions;
        const bool are_floats = std::ranges::all_of(positions, [](fresco::Vec3d p)
                                                    { return fresco::vec_cast<double>(fresco::vec_cast<float>(p)) == p; });
        scan_mesh::to_world(positions, *unit_m, rotation, world_from_file);
        place(surface, positions,
              frames.has_value() ? fresco::recordings::offset_beside(frames->offset_m, positions, path->path.string())
                                 : fresco::offset_for(positions));
        fresco::tell_offset(surface.offset_m, run);
        if (are_floats && surface.offset_m != fresco::Vec3d{})
            run.warning(of_model("all its coordinates are floats, which are more than 0.1 mm apart so far from 0: export it in "
                                 "double (a PLY of type double, an OBJ with all digits) or nearer to 0"));
        check_mesh(surface, path->path.string() + " in meters");
        run.report("vertices_joined", read.split_vertices ? scan_mesh::join_vertices(surface) : 0);

        fresco::Model textured;
        for (const auto& picture : read.pictures)
            textured.pictures.push_back(store(picture, textured.pictures.size(), read.is_gltf));
        textured.mesh = surface;
        textured.materials = std::move(read.materials);
        textured.material_of_face = std::move(read.material_of_face);
        tell(read, textured, run);
        read.object_of_face.resize(surface.triangles.size(), scan_mesh::ObjectNumbers::most_objects);
        if (read.objects.size() == scan_mesh::ObjectNumbers::most_objects)
            run.warning(of_model(fmt::format("only its first {} objects have a region each", read.objects.size())));
        objects = regions_from(surface, read.objects, read.object_of_face);
        model = std::move(textured);
        mesh = std::move(surface);
    }

    static std::vector<fresco::FileFormat> formats()
    {
        auto formats = scan_mesh::model_formats();
        formats.push_back(scan_mesh::blender_format());
        return formats;
    }

    scan_mesh::FileModel read_model(fresco::RunContext& run) const
    {
        const auto read = [&](const std::filesystem::path& file)
        { return scan_mesh::read_file_model(file, *materials != "skip"); };
        const auto extensions = scan_mesh::blender_format().extensions;
        if (std::ranges::find(extensions, fresco::lower_extension(path->path)) == extensions.end())
            return read(path->path);
        const auto glb = scan_mesh::glb_by_blender(path->path, run);
        const auto of_original = [&](const std::string& text)
        { return fresco::recordings::renamed(text, glb, path->path.string()); };
        try
        {
            auto converted = read(glb);
            for (auto& picture : converted.pictures)
                picture.name = of_original(picture.name);
            return converted;
        }
        catch (const fresco::Error& error)
        {
            throw fresco::Error(of_original(error.what()));
        }
    }

    /// Checks a picture and copies it into the model's folder. Returns its name there.
    std::string store(const scan_mesh::FilePicture& picture, std::size_t number, bool is_gltf) const
    {
        auto bytes = picture.file.empty() ? picture.bytes : fresco::read_file(picture.file);
        if (is_gltf)
            bytes = scan_mesh::without_profile(std::move(bytes));
        std::string name = fmt::format("picture_{}{}", number, scan_mesh::suffix_of(bytes));
        const auto file = model.folder().path / name;
        fresco::write_file(file, bytes);
        try
        {
            const auto header = images.has_value() ? images->check(file) : fresco::ImageHeader();
            if (!is_gltf)
                fresco::recordings::check_not_turned(file, header, "a model");
        }
        catch (const fresco::Error& error)
        {
            throw fresco::Error(fresco::recordings::renamed(error.what(), file, picture.name));
        }
        return name;
    }

    void tell(const scan_mesh::FileModel& read, const fresco::Model& made, fresco::RunContext& run) const
    {
        const auto extent = scan_mesh::extent_of(made.mesh);
        if (const auto doubts = fresco::recordings::doubts_about_size(extent, *unit_m); !doubts.empty())
            run.warning(doubts);
        run.report("faces", made.mesh.triangles.size());
        run.report("extent_m", fresco::Value::List{extent.x, extent.y, extent.z});
        run.report("polygons_split", read.report.polygons_split);
        run.report("degenerate_dropped", read.report.degenerate_dropped);
        run.report("materials", made.materials.size());
        run.report("objects", read.objects.size());
        run.report("pictures", made.pictures.size());
        const std::size_t count = made.pictures.size();
        const std::string pictures = count == 0 ? "" : fmt::format(", {} picture{}", count, count == 1 ? "" : "s");
        run.message(fmt::format("{} faces, {} x {} x {} m{}", made.mesh.triangles.size(), meters(extent.x), meters(extent.y),
                                meters(extent.z), pictures));
    }

    static std::string meters(double length) { return fresco::to_json(std::round(length * 100) / 100); }
};

}  // namespace

FRESCO_STAGE("scan.mesh", ScanMesh, "A mesh or textured model from a file, transformed to world axes and meters")
