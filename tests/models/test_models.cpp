#include "catch.h"
#include "model_samples.h"

#include <fresco/files.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

#include <cmath>
#include <memory>
#include <string>

using namespace fresco;
using model_samples::Box;

namespace
{

constexpr int texture_px = 256;

/// The stages from a model's file to its bake.
class Chain
{
  public:
    explicit Chain(const std::filesystem::path& model)
    {
        run("scan.mesh", Value::Map{{"path", model.string()}}, {});
        model_ = Model::load(output("model"));
        run("mesh.decimate", Value::Map{}, {{"mesh", Mesh::load(output("mesh"))}});
        run("atlas.project", Value::Map{{"size_px", texture_px}}, {{"mesh", Mesh::load(output("simplified"))}});
        atlas_ = Mesh::load(output("atlas"));
        run("texture.from_model", Value::Map{{"size_px", texture_px}}, {{"model", model_}, {"mesh", atlas_}});
        run("texture.bake", Value::Map{}, {{"texture", Texture::load(output("texture"))}, {"mesh", atlas_}});
        baked_ = TexturedMesh::load(output("textured_mesh"));
    }

    /// The export's main file.
    std::filesystem::path exported(const std::string& type, const std::string& path)
    {
        run(type, Value::Map{{"path", path}, {"up", "keep"}}, {{"textured_mesh", baked_}});
        return folder_.path() / "files" / Files::load(output("files"))->names.at(0);
    }

    const Model& model() const { return *model_; }

    /// The baked color at a point of the surface, on the face that holds it and looks along `normal`.
    Rgb8 color_at(Vec3f p, Vec3f normal) const
    {
        const Mesh& mesh = baked_->mesh;
        const auto normals = face_normals(mesh);
        for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        {
            const auto& t = mesh.triangles[face];
            const Vec3f a = mesh.positions[t[0]];
            const Vec3f side1 = mesh.positions[t[1]] - a;
            const Vec3f side2 = mesh.positions[t[2]] - a;
            if (dot(normals[face], normal) < 0.99F || std::abs(dot(normals[face], p - a)) > 1e-4F)
                continue;
            const float area = dot(cross(side1, side2), normals[face]);
            const float w1 = dot(cross(p - a, side2), normals[face]) / area;
            const float w2 = dot(cross(side1, p - a), normals[face]) / area;
            if (w1 < -1e-4F || w2 < -1e-4F || w1 + w2 > 1.0001F)
                continue;
            const Vec2f uv =
                mesh.texcoords[3 * face] * (1 - w1 - w2) + mesh.texcoords[3 * face + 1] * w1 + mesh.texcoords[3 * face + 2] * w2;
            const auto& pixels = baked_->image.pixels;
            const auto texel = [&](float at)
            { return std::min(static_cast<int>(at * static_cast<float>(pixels.width)), pixels.width - 1); };
            const std::uint8_t* const rgb = &pixels.at(texel(uv.x), texel(1 - uv.y));
            return {rgb[0], rgb[1], rgb[2]};
        }
        FAIL("no face at the point");
        return {};
    }

  private:
    ArtifactFolder output(const std::string& port) const { return {folder_.path() / port, folder_.path()}; }

    void run(const std::string& type, const Value& options, const testing::Inputs& inputs)
    {
        std::string library = type;
        library.replace(library.find('.'), 1, "_");
        testing::TestRun test_run;
        testing::run_stage(std::string(FRESCO_PLUGINS) + "/" + library + ".so", type, options, inputs, folder_.path(), test_run,
                           {{"image_io", std::make_shared<stored_png::Codec>()}});
    }

    testing::TemporaryFolder folder_;
    std::shared_ptr<const Model> model_;
    std::shared_ptr<const Mesh> atlas_;
    std::shared_ptr<const TexturedMesh> baked_;
};

void check_sides(const Chain& chain)
{
    for (std::size_t side = 0; side < Box::sides; ++side)
    {
        const auto corners = Box::corners(side);
        const Vec3f normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
        for (const float u : {0.1F, 0.4F, 0.6F, 0.9F})
            for (const float v : {0.1F, 0.4F, 0.6F, 0.9F})
            {
                INFO("side " << side << " at " << u << ", " << v);
                CHECK(chain.color_at(Box::point(side, u, v), normal) == Box::color(side, u, v));
            }
    }
}

}  // namespace

TEST_CASE("a box of six materials comes out with the right color everywhere, from each format")
{
    const testing::TemporaryFolder folder;
    for (const auto& file : {model_samples::write_glb_box(folder.path()), model_samples::write_obj_box(folder.path()),
                             model_samples::write_ply_box(folder.path())})
    {
        INFO(file.filename());
        const Chain chain(file);
        CHECK(chain.model().pictures.size() == 6);
        check_sides(chain);
    }
}

TEST_CASE("what is exported is read again with its picture, in each format")
{
    const testing::TemporaryFolder folder;
    Chain chain(model_samples::write_glb_box(folder.path()));
    for (const auto& [type, path] :
         {std::pair{"export.gltf", "room.glb"}, {"export.mesh", "room.obj"}, {"export.mesh", "room.ply"}})
    {
        INFO(path);
        const Chain again(chain.exported(type, path));
        CHECK(again.model().pictures.size() == 1);
        CHECK(again.model().mesh.positions.size() == 8);
        check_sides(again);
    }
}
